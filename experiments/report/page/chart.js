"use strict";
// Charts of the plans: axes with the values that occur, and a mark for each plan, chosen by mouse, touch and keyboard.

const LETTER = 8; // width of a digit, pixels
const LABEL_HEIGHT = 14; // pixels
const NUMBERED = 14; // most points that show their numbers

// What a plan is worth, in words.
function worthOf(plan) {
  if (!plan.worth) return `Cost ${show(plan.cost)}, penalty ${show(plan.preference)}`;
  return plan.worth.map(([name, value]) => `${name} ${show(value)}`).join(", ");
}

function widest(texts) {
  return LETTER * Math.max(...texts.map((text) => text.length));
}

// The places of rising values between two ends of an axis.
function placesOf(values, from, to) {
  const low = values[0], range = values[values.length - 1] - low;
  return values.map((value) => from + (range ? (value - low) / range : 0.5) * (to - from));
}

// The indices of the places whose labels, `size` pixels long, do not overlap; the ends come first.
function labelled(places, size) {
  const kept = [];
  for (const i of [0, places.length - 1, ...places.keys()]) {
    if (kept.every((other) => Math.abs(places[i] - places[other]) >= size)) kept.push(i);
  }
  return kept;
}

class PlanChart {
  // `axes`: of each objective its name, the values that occur, rising, and their texts; `ranks`: of each plan the
  // ranks of its values among those; `kind`: class of the chart; `name`: for those who cannot see it.
  constructor(place, { plans, axes, ranks }, kind, name, choose) {
    Object.assign(this, { place, plans, axes, ranks, chosen: [-1, -1], beyond: new Set() });
    this.scenery = draw("g", { class: "axes", "aria-hidden": "true" });
    this.marks = plans.map((plan) => this.mark(plan, choose));
    this.group = draw("g", {}, ...this.marks);
    this.labels = draw("g", { class: "labels", "aria-hidden": "true" });
    this.svg = draw("svg", { class: `plot ${kind}`, role: "group", "aria-label": `${name}; arrow keys go from one to the next` }, this.scenery, this.group, this.labels);
    place.append(scrollBox(name, "", this.svg));
    new ResizeObserver(() => this.draw()).observe(place);
  }

  mark(plan, choose) {
    const mark = draw("g", { role: "button", tabindex: plan.index ? -1 : 0, "data-plan": plan.index },
      draw("title", {}, `Plan ${plan.index}: ${worthOf(plan).replace("Cost", "cost")}`), ...this.shape(plan));
    mark.onclick = (event) => choose(plan.index, event.shiftKey);
    mark.onfocus = () => { for (const other of this.marks) other.setAttribute("tabindex", other === mark ? 0 : -1); };
    mark.onkeydown = (event) => {
      const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      const goes = event.key === "Enter" || event.key === " ";
      if (!by && !goes) return;
      event.preventDefault();
      event.stopPropagation();
      if (goes) choose(plan.index, event.shiftKey);
      else this.marks[(plan.index + by + this.marks.length) % this.marks.length].focus();
    };
    return mark;
  }

  // Empty the chart but for its marks.
  clear(width, height) {
    this.svg.setAttribute("width", width);
    this.svg.setAttribute("height", height);
    this.scenery.replaceChildren();
    this.labels.replaceChildren();
  }

  // Draw an axis along a path: a tick for each value, and labels of a size where there is space.
  axis({ texts }, places, path, size, tick, label) {
    this.scenery.append(draw("path", { d: path }), ...places.map((at) => draw("path", { class: "tick", d: tick(at) })));
    for (const i of labelled(places, size)) this.labels.append(draw("text", { dy: "0.35em", ...label(places[i]) }, texts[i]));
  }

  // Draw a vertical axis, its labels to the left (-1) or right (1).
  upright(axis, places, x, bottom, top, side) {
    this.axis(axis, places, `M${x} ${bottom}V${top}`, LABEL_HEIGHT, (y) => `M${x - 4} ${y}h8`,
      (y) => ({ x: x + 8 * side, y, "text-anchor": side < 0 ? "end" : "start" }));
  }

  show(chosen, other) {
    this.chosen = [chosen, other === null ? -1 : other];
    this.update();
  }

  // `beyond`: the plans that exceed a wish.
  wish(bounds, beyond) {
    Object.assign(this, { bounds, beyond });
    this.update();
  }

  update() {
    this.marks.forEach((mark, index) => {
      const role = this.chosen.indexOf(index), beyond = this.beyond.has(index);
      mark.setAttribute("class", [this.kind, ["first", "second"][role], beyond && "beyond"].filter(Boolean).join(" "));
      mark.setAttribute("aria-pressed", String(role >= 0));
      mark.setAttribute("aria-label", `${mark.firstChild.textContent}${beyond ? ", exceeds a wish" : ""}`);
    });
    this.stack();
  }

  // Chosen marks lie above others, and plans beyond a wish below. A mark that is moved would lose the focus.
  stack() {
    const rank = (mark) => ["beyond", "", "second", "first"].findLastIndex((kind) => (kind ? mark.classList.contains(kind) : !mark.classList.contains("beyond")));
    let held = this.marks.includes(document.activeElement) ? document.activeElement : null;
    for (const mark of [...this.marks].sort((a, b) => rank(a) - rank(b))) {
      if (mark === held) held = null;
      else this.group.insertBefore(mark, held);
    }
  }
}

// Two objectives: a point for each plan, and a line through those that no other beats in these two.
class FrontChart extends PlanChart {
  kind = "point";

  // `titles`: of the axes if there is no choice, or null.
  constructor(place, data, titles, choose) {
    super(place, data, data.plans.length > NUMBERED ? "many" : "few", "The Pareto front", choose);
    this.titles = titles;
    this.selects = ["across", "up"].map((id) => document.getElementById(id)).filter(Boolean);
    for (const select of this.selects) select.onchange = () => this.draw();
  }

  shape(plan) {
    return [
      draw("circle", { class: "hit", r: 12 }), draw("rect", { class: "stroke", x: -7.5, y: -7.5, width: 15, height: 15 }),
      draw("text", { class: "number", x: 8, y: -14 }, String(plan.index))];
  }

  draw() {
    const [across, up] = this.selects.length ? this.selects.map((select) => select.selectedIndex) : [0, 1];
    const width = this.place.clientWidth, height = innerWidth <= 600 ? 240 : 320, [a, b] = [this.axes[across], this.axes[up]];
    const left = 34 + widest(b.texts), right = width - 12 - widest(a.texts) / 2, top = 12, bottom = height - 44;
    const xs = placesOf(a.values, left + 0.06 * (right - left), right - 0.06 * (right - left));
    const ys = placesOf(b.values, bottom - 0.06 * (bottom - top), top + 0.1 * (bottom - top));
    this.clear(width, height);
    if (a.values.length <= NUMBERED) for (const x of xs) this.scenery.append(draw("path", { class: "grid", d: `M${x} ${bottom}V${top}` }));
    if (b.values.length <= NUMBERED) for (const y of ys) this.scenery.append(draw("path", { class: "grid", d: `M${left} ${y}H${right}` }));
    this.upright(b, ys, left, bottom, top, -1);
    this.axis(a, xs, `M${left} ${bottom}H${right}`, 8 + widest(a.texts), (x) => `M${x} ${bottom - 4}v8`, (x) => ({ x, y: bottom + 14, "text-anchor": "middle" }));
    const points = this.ranks.map((rank) => [xs[rank[across]], ys[rank[up]]]);
    this.scenery.append(
      draw("text", { class: "axis-name", x: (left + right) / 2, y: height - 6 }, `${this.titles ? this.titles[0] : a.name} →`),
      draw("text", { class: "axis-name", transform: `translate(14 ${height / 2}) rotate(-90)` }, `← ${this.titles ? this.titles[1] : b.name} (lower is better)`),
      draw("path", { d: this.border(points) }));
    this.marks.forEach((mark, i) => mark.setAttribute("transform", `translate(${points[i].join(" ")})`));
    this.update();
  }

  // Steps from left to right; pixels count downwards, so that lower is greater.
  border(points) {
    let lowest = -Infinity, path = "";
    for (const [x, y] of [...points].sort((one, two) => one[0] - two[0] || two[1] - one[1])) {
      if (y <= lowest) continue;
      path += path ? `H${x}V${y}` : `M${x} ${y}`;
      lowest = y;
    }
    return path;
  }
}
