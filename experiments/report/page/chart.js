"use strict";
// Charts of the plans: axes with the values that occur, and a mark for each plan, chosen by mouse, touch and keyboard.

const LETTER = 8; // width of a digit, pixels
const LABEL_HEIGHT = 14, NAME_HEIGHT = 18; // pixels
const NUMBERED = 14; // most points that show their numbers
const BESIDE_AXIS = 20; // beside the labels of one of several upright axes, pixels
const LEAST_GAP = 72; // between two of them, pixels; where they need more, the picture scrolls
const LINES_HEIGHT = 340, BELOW_AXES = 12; // of a picture with a line for each plan, pixels

function widest(texts) {
  return LETTER * Math.max(...texts.map((text) => text.length));
}

// The places of rising values between two ends of an axis, `inset` away from them as a share of its length.
function placesOf(values, from, to, inset = 0) {
  const low = values[0], range = values[values.length - 1] - low;
  return values.map((value) => from + (inset + (1 - 2 * inset) * (range ? (value - low) / range : 0.5)) * (to - from));
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
  // ranks of its values among those.
  constructor(place, { plans, axes, ranks }, choose) {
    Object.assign(this, { place, axes, ranks, state: { bounds: [], beyond: new Set() } });
    this.scenery = draw("g", { class: "axes", "aria-hidden": "true" });
    this.marks = plans.map((plan) => this.mark(plan, choose));
    this.group = draw("g", {}, ...this.marks);
    this.labels = draw("g", { class: "labels", "aria-hidden": "true" });
    this.svg = draw("svg", { class: plans.length > NUMBERED ? "plot many" : "plot", role: "group", "aria-label": "The Pareto front; arrow keys go from one to the next" },
      this.scenery, this.group, this.labels);
    place.append(scrollBox("The Pareto front", "", this.svg));
    walkable(this.marks);
    new ResizeObserver(() => this.update()).observe(place);
  }

  mark(plan, choose) {
    const mark = draw("g", { role: "button", "data-plan": plan.index },
      draw("title", {}, `Plan ${plan.index}: ${plan.worth}`), ...this.shape(plan));
    mark.onclick = (event) => choose(plan.index, event.shiftKey);
    mark.onkeydown = (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      choose(plan.index, event.shiftKey);
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

  // Show the `chosen` plan, the `other` that it is compared with, if any, the largest rank that is wished for on each
  // axis (`bounds`), and the plans `beyond` a wish.
  update(state = {}) {
    Object.assign(this.state, state);
    this.draw();
    const { chosen, other, beyond } = this.state, held = document.activeElement;
    this.marks.forEach((mark, i) => {
      const role = i === chosen ? "first" : i === other ? "second" : "";
      mark.setAttribute("class", `${this.kind} ${role} ${beyond.has(i) ? "beyond" : ""}`);
      mark.setAttribute("aria-pressed", String(Boolean(role)));
      mark.setAttribute("aria-label", `${mark.firstChild.textContent}${beyond.has(i) ? ", exceeds a wish" : ""}`);
    });
    // Chosen marks lie above others, and plans beyond a wish below.
    const level = (i) => (i === chosen ? 3 : i === other ? 2 : beyond.has(i) ? 0 : 1);
    const order = [...this.marks.keys()].sort((i, j) => level(i) - level(j));
    this.group.append(...order.map((i) => this.marks[i]));
    if (this.marks.includes(held)) held.focus({ preventScroll: true });
  }
}

// Two objectives: a point for each plan, and a line through them.
class FrontChart extends PlanChart {
  kind = "point";

  shape(plan) {
    return [
      draw("circle", { class: "hit", r: 12 }), draw("rect", { class: "stroke", x: -7.5, y: -7.5, width: 15, height: 15 }),
      draw("text", { class: "number", x: 8, y: -14 }, String(plan.index))];
  }

  draw() {
    const [a, b] = this.axes, width = this.place.clientWidth, height = innerWidth <= 600 ? 240 : 320;
    const x0 = 34 + widest(b.texts), x1 = width - 12 - widest(a.texts) / 2, y0 = height - 44, y1 = 12;
    const xs = placesOf(a.values, x0, x1, 0.06), ys = placesOf(b.values, y0, y1, 0.08);
    const points = this.ranks.map(([across, up]) => [xs[across], ys[up]]);
    this.clear(width, height);
    this.grid(xs, (x) => `M${x} ${y0}V${y1}`);
    this.grid(ys, (y) => `M${x0} ${y}H${x1}`);
    this.upright(b, ys, x0, y0, y1, -1);
    this.axis(a, xs, `M${x0} ${y0}H${x1}`, 8 + widest(a.texts), (x) => `M${x} ${y0 - 4}v8`, (x) => ({ x, y: y0 + 14, "text-anchor": "middle" }));
    this.scenery.append(
      draw("text", { class: "axis-name", x: (x0 + x1) / 2, y: height - 6 }, `${a.name} →`),
      draw("text", { class: "axis-name", transform: `translate(14 ${height / 2}) rotate(-90)` }, `← ${b.name} (lower is better)`),
      draw("path", { d: `M${points.map(([x, y], i) => (i ? `H${x}V${y}` : `${x} ${y}`)).join("")}` }));
    this.marks.forEach((mark, i) => mark.setAttribute("transform", `translate(${points[i].join(" ")})`));
  }

  grid(places, line) {
    if (places.length <= NUMBERED) this.scenery.append(...places.map((at) => draw("path", { class: "grid", d: line(at) })));
  }
}

// Parallel coordinates: an upright axis for each objective, and a line for each plan.
class ParallelCoordinates extends PlanChart {
  kind = "line";

  shape(plan) {
    const badge = draw("g", { class: "disc" }, draw("circle", { r: 10 }), draw("text", { dy: "0.35em" }, String(plan.index)));
    return [draw("path", { class: "hit" }), draw("path", { class: "stroke" }), badge];
  }

  draw() {
    const { axes } = this, count = axes.length - 1, bottom = LINES_HEIGHT - BELOW_AXES;
    const beside = axes.map(({ texts }) => BESIDE_AXIS + widest(texts)), sides = beside[0] + beside[count];
    const width = Math.max(this.place.clientWidth, sides + count * Math.max(LEAST_GAP, ...beside.slice(1, count)));
    const across = axes.map((_, k) => beside[0] + (k * (width - sides)) / count);
    this.clear(width, LINES_HEIGHT);
    // Names stand above their axes, in rows where side by side they would overlap.
    const rows = Math.ceil((LETTER + widest(axes.map(({ name }) => name))) / (across[1] - across[0]));
    const top = NAME_HEIGHT * rows + LABEL_HEIGHT;
    axes.forEach(({ name }, k) => {
      const half = widest([name]) / 2, x = Math.max(half, Math.min(across[k], width - half));
      this.scenery.append(draw("text", { class: "axis-name", x, y: NAME_HEIGHT * ((k % rows) + 0.75) }, name));
    });
    const places = axes.map(({ values }) => placesOf(values, bottom, top));
    const points = this.ranks.map((ranks) => ranks.map((rank, k) => [across[k], places[k][rank]]));
    axes.forEach((axis, k) => {
      // What lies above a wish is barred.
      const most = this.state.bounds[k], free = !(most < axis.values.length - 1);
      this.scenery.append(draw("path", { class: "barred", d: free ? "" : `M${across[k]} ${places[k][most] - 4}V${top}` }));
      this.upright(axis, places[k], across[k], bottom, top, k ? 1 : -1);
    });
    this.marks.forEach((mark, i) => {
      for (const path of mark.querySelectorAll("path")) path.setAttribute("d", `M${points[i].map((point) => point.join(" ")).join("L")}`);
      // The number of a chosen plan stands on its line between the first two axes.
      const [[x, y], [u, v]] = points[i], share = i === this.state.other ? 0.7 : 0.3;
      mark.querySelector(".disc").setAttribute("transform", `translate(${x + share * (u - x)} ${y + share * (v - y)})`);
    });
  }
}
