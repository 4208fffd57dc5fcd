"use strict";
// A grid plan on its map: its path (drawn by prefplan), the part already taken, and the robot.

function draw(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

class GridMap {
  constructor(map, plan) {
    this.plan = plan;
    const picture = document.getElementById(`map-${plan.index}`).content.cloneNode(true);
    const svg = picture.querySelector("svg");
    svg.setAttribute("aria-label", plan.map_words);
    const [, , wide, high] = svg.getAttribute("viewBox").split(" ").map(Number), [columns, rows] = map.size;
    this.points = plan.path.map(([x, y]) => [((x + 0.5) * wide) / columns, ((rows - 0.5 - y) * high) / rows]);
    this.gone = draw("polyline", { class: "gone", points: "" });
    this.robot = draw("circle", { class: "robot", r: Math.min(Math.max((0.32 * wide) / columns, 2.5), 9) });
    svg.querySelector(".path").after(this.gone);
    svg.append(this.robot);
    svg.removeAttribute("width");
    svg.removeAttribute("height");
    this.element = make("div", { class: "picture" });
    this.element.append(picture);
  }

  show(time) {
    const { done, now } = progress(this.plan, time);
    let at = this.points[done];
    if (now !== null) {
      const [start, end] = this.plan.times[now];
      const share = Math.max(0, Math.min(1, (time - start) / (end - start)));
      const [[x, y], [u, v]] = [this.points[done], this.points[done + 1]];
      at = [x + share * (u - x), y + share * (v - y)];
    }
    this.robot.setAttribute("cx", at[0]);
    this.robot.setAttribute("cy", at[1]);
    this.gone.setAttribute("points", [...this.points.slice(0, done + 1), at].map((point) => point.join(",")).join(" "));
  }
}
