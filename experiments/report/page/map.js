"use strict";
// A grid plan on its map: its path (drawn by prefplan), the part already taken, and the robot.

function draw(tag, attributes = {}) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

class GridMap {
  constructor(map, plan) {
    this.plan = plan;
    const picture = document.getElementById(`map-${plan.index}`).content.cloneNode(true);
    const svg = picture.querySelector("svg");
    svg.setAttribute("aria-label", plan.map_words);
    const path = svg.querySelector(".path");
    this.points = path.dataset.states.split(" ").map((point) => point.split(",").map(Number));
    const [, , width] = svg.getAttribute("viewBox").split(" ").map(Number);
    const cell = (width - 2) / map.size[0];
    this.gone = draw("polyline", { class: "gone", points: "" });
    this.robot = draw("circle", { class: "robot", r: Math.max(0.32 * cell, 4) });
    path.after(this.gone);
    svg.querySelector(".ground").after(this.cells(map.size, cell));
    svg.append(this.robot);
    svg.removeAttribute("width");
    svg.removeAttribute("height");
    this.element = make("div", { class: "picture" });
    this.element.append(picture);
  }

  cells([width, height], cell) {
    let d = "";
    if (cell >= 4) {
      for (let x = 1; x < width; x += 1) d += `M${x * cell} 0V${height * cell}`;
      for (let y = 1; y < height; y += 1) d += `M0 ${y * cell}H${width * cell}`;
    }
    return draw("path", { class: "grid-lines", d });
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
