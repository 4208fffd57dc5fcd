"use strict";
// Parallel coordinates: an axis for each objective, and a line for each plan.

const BESIDE_AXIS = 20; // beside the labels of an axis, pixels
const LEAST_GAP = 72; // between two axes, pixels; where they need more, the picture scrolls
const HEIGHT = 340, BELOW_AXES = 12, NAME_HEIGHT = 18; // pixels

class ParallelCoordinates extends PlanChart {
  kind = "line";

  constructor(place, data, choose) {
    super(place, data, "parallel", "All objectives at once", choose);
    this.bounds = this.axes.map((axis) => axis.values.length - 1);
  }

  shape(plan) {
    const badge = draw("g", { class: "disc" }, draw("circle", { r: 10 }), draw("text", { dy: "0.35em" }, String(plan.index)));
    return [draw("path", { class: "hit" }), draw("path", { class: "stroke" }), badge];
  }

  draw() {
    const { axes } = this, count = axes.length - 1, bottom = HEIGHT - BELOW_AXES;
    const beside = axes.map(({ texts }) => BESIDE_AXIS + widest(texts)), sides = beside[0] + beside[count];
    const width = Math.max(this.place.clientWidth, sides + count * Math.max(LEAST_GAP, ...beside.slice(1, count)));
    const across = axes.map((_, k) => beside[0] + (k * (width - sides)) / count);
    this.clear(width, HEIGHT);
    this.top = NAME_HEIGHT * this.names(across, width) + LABEL_HEIGHT;
    this.places = axes.map(({ values }) => placesOf(values, bottom, this.top));
    this.barred = axes.map((axis, k) => {
      const barred = draw("path", { class: "barred" });
      this.scenery.append(barred);
      this.upright(axis, this.places[k], across[k], bottom, this.top, k ? 1 : -1);
      return barred;
    });
    this.points = this.ranks.map((ranks) => ranks.map((rank, k) => [across[k], this.places[k][rank]]));
    this.marks.forEach((mark, i) => {
      for (const path of mark.querySelectorAll("path")) path.setAttribute("d", `M${this.points[i].map((point) => point.join(" ")).join("L")}`);
    });
    this.update();
  }

  // Write the names above the axes, in rows where side by side they would overlap; return the number of rows.
  names(across, width) {
    const ends = [];
    this.axes.forEach(({ name }, k) => {
      const text = draw("text", { class: "axis-name" }, name);
      this.scenery.append(text);
      const size = text.getComputedTextLength(), from = Math.max(0, Math.min(across[k] - size / 2, width - size));
      let row = ends.findIndex((end) => end < from - 8);
      if (row < 0) row = ends.length;
      ends[row] = from + size;
      text.setAttribute("x", from + size / 2);
      text.setAttribute("y", NAME_HEIGHT * (row + 0.75));
    });
    return ends.length;
  }

  // `bounds`: for each axis, the rank of the largest value allowed. What lies above is barred.
  update() {
    super.update();
    if (!this.points) return;
    this.barred.forEach((path, k) => {
      const [x] = this.points[0][k], free = this.bounds[k] === this.axes[k].values.length - 1;
      path.setAttribute("d", free ? "" : `M${x} ${this.places[k][this.bounds[k]] - 4}V${this.top}`);
    });
    // The number of a chosen plan stands on its line between the first two axes.
    this.chosen.forEach((index, role) => {
      if (index < 0) return;
      const [from, to] = this.points[index], share = role ? 0.7 : 0.3;
      const at = [0, 1].map((i) => from[i] + share * (to[i] - from[i]));
      this.marks[index].querySelector(".disc").setAttribute("transform", `translate(${at.join(" ")})`);
    });
  }
}
