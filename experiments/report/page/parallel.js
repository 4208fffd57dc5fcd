"use strict";
// Parallel coordinates: an axis for each objective, a line for each plan that can be chosen by mouse, touch and keyboard.

const BESIDE_AXIS = 20; // beside the labels of an axis, pixels
const LEAST_GAP = 72; // between two axes, pixels; where they need more, the picture scrolls
const HEIGHT = 340, BELOW_AXES = 12, NAME_HEIGHT = 18, LABEL_HEIGHT = 14; // pixels

class ParallelCoordinates {
  // `axes`: of each objective its name, the values that occur, rising, and their texts; `places`: of each plan the
  // places of its values among those.
  constructor(place, { axes, places }, plans, choose) {
    Object.assign(this, { axes, places, chosen: [-1, -1], beyond: new Set(), bounds: axes.map((axis) => axis.values.length - 1) });
    this.scenery = draw("g", { class: "axes", "aria-hidden": "true" });
    this.group = draw("g");
    this.labels = draw("g", { class: "labels", "aria-hidden": "true" });
    this.svg = draw("svg", { class: "parallel", role: "group", "aria-label": "The plans in parallel coordinates; arrow keys go from one to the next" });
    this.svg.append(this.scenery, this.group, this.labels);
    this.lines = plans.map((plan) => this.line(plan, choose));
    place.append(scrollBox("All objectives at once", "", this.svg));
    this.place = place;
    new ResizeObserver(() => this.draw()).observe(place);
  }

  line(plan, choose) {
    const line = draw("g", { class: "line", role: "button", tabindex: plan.index ? -1 : 0, "data-plan": plan.index });
    line.append(draw("path", { class: "hit" }), draw("path", { class: "stroke" }), draw("circle", { class: "disc", r: 10 }), draw("text", { dy: "0.35em" }));
    line.lastChild.textContent = String(plan.index);
    line.prepend(draw("title"));
    line.firstChild.textContent = `Plan ${plan.index}: ${worthOf(plan)}`;
    line.onclick = (event) => choose(plan.index, event.shiftKey);
    line.onfocus = () => { for (const other of this.lines) other.setAttribute("tabindex", other === line ? 0 : -1); };
    line.onkeydown = (event) => {
      const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      const goes = event.key === "Enter" || event.key === " ";
      if (!by && !goes) return;
      event.preventDefault();
      event.stopPropagation();
      if (goes) choose(plan.index, event.shiftKey);
      else this.lines[(plan.index + by + this.lines.length) % this.lines.length].focus();
    };
    return line;
  }

  draw() {
    const { axes } = this, count = axes.length - 1;
    const beside = axes.map(({ texts }) => BESIDE_AXIS + LETTER * Math.max(...texts.map((text) => text.length)));
    const sides = beside[0] + beside[count];
    const width = Math.max(this.place.clientWidth, sides + count * Math.max(LEAST_GAP, ...beside.slice(1, count)));
    this.across = axes.map((_, k) => beside[0] + (k * (width - sides)) / count);
    this.svg.setAttribute("width", width);
    this.svg.setAttribute("height", HEIGHT);
    this.scenery.replaceChildren();
    this.labels.replaceChildren();
    this.top = NAME_HEIGHT * this.names(width) + LABEL_HEIGHT;
    this.bottom = HEIGHT - BELOW_AXES;
    axes.forEach((axis, k) => this.axis(axis, k));
    this.lines.forEach((line, i) => {
      const points = this.places[i].map((at, k) => [this.across[k], this.up(k, at)]);
      for (const path of line.querySelectorAll("path")) path.setAttribute("d", `M${points.map((point) => point.join(" ")).join("L")}`);
    });
    this.update();
  }

  // The height of a value on its axis; the least is at the bottom.
  up(k, at) {
    const { values } = this.axes[k], low = values[0], range = values[values.length - 1] - low;
    return this.bottom - (range ? ((values[at] - low) / range) * (this.bottom - this.top) : 0);
  }

  // Write the names above the axes, in rows where side by side they would overlap; return the number of rows.
  names(width) {
    const ends = [];
    this.axes.forEach(({ name }, k) => {
      const text = draw("text", { class: "axis-name" });
      text.textContent = name;
      this.scenery.append(text);
      const size = text.getComputedTextLength(), from = Math.max(0, Math.min(this.across[k] - size / 2, width - size));
      let row = ends.findIndex((end) => end < from - 8);
      if (row < 0) row = ends.length;
      ends[row] = from + size;
      text.setAttribute("x", from);
      text.setAttribute("y", NAME_HEIGHT * (row + 0.75));
    });
    return ends.length;
  }

  axis({ values, texts }, k) {
    const x = this.across[k], labelled = labelledOf(values, LABEL_HEIGHT, this.bottom - this.top);
    this.scenery.append(draw("path", { class: "barred" }), draw("path", { d: `M${x} ${this.bottom}V${this.top}` }));
    values.forEach((value, at) => {
      const y = this.up(k, at);
      this.scenery.append(draw("path", { class: "tick", d: `M${x - 4} ${y}h8` }));
      if (!labelled.includes(value)) return;
      const label = draw("text", { x: x + (k ? 8 : -8), y, dy: "0.35em", "text-anchor": k ? "start" : "end" });
      label.textContent = texts[at];
      this.labels.append(label);
    });
  }

  show(chosen, other) {
    this.chosen = [chosen, other === null ? -1 : other];
    this.update();
  }

  // `bounds`: for each axis, the rank of the largest value allowed; `beyond`: the plans that exceed one.
  wish(bounds, beyond) {
    Object.assign(this, { bounds, beyond });
    this.update();
  }

  update() {
    if (!this.across) return;
    const kinds = ["first", "second"];
    this.lines.forEach((line, index) => {
      const role = this.chosen.indexOf(index);
      kinds.forEach((kind, k) => line.classList.toggle(kind, k === role));
      line.classList.toggle("beyond", this.beyond.has(index));
      line.setAttribute("aria-pressed", String(role >= 0));
      line.setAttribute("aria-label", `${line.firstChild.textContent}${this.beyond.has(index) ? ", exceeds a wish" : ""}`);
      this.badge(line, index, role);
    });
    this.scenery.querySelectorAll(".barred").forEach((path, k) => {
      const barred = this.bounds[k] < this.axes[k].values.length - 1;
      path.setAttribute("d", barred ? `M${this.across[k]} ${this.up(k, this.bounds[k]) - 4}V${this.top}` : "");
    });
    this.stack();
  }

  // The number of a chosen plan, on its line between the first two axes.
  badge(line, index, role) {
    const [from, to] = [0, 1].map((k) => this.up(k, this.places[index][k])), share = role ? 0.7 : 0.3;
    const at = { x: this.across[0] + share * (this.across[1] - this.across[0]), y: from + share * (to - from) };
    line.querySelector("text").setAttribute("x", at.x);
    line.querySelector("text").setAttribute("y", at.y);
    line.querySelector("circle").setAttribute("cx", at.x);
    line.querySelector("circle").setAttribute("cy", at.y);
  }

  // Chosen lines lie above others, and plans beyond a wish below. A line that is moved would lose the focus.
  stack() {
    const rank = (line) => ["beyond", "", "second", "first"].findLastIndex((kind) => !kind ? !line.classList.contains("beyond") : line.classList.contains(kind));
    let held = this.lines.includes(document.activeElement) ? document.activeElement : null;
    for (const line of [...this.lines].sort((a, b) => rank(a) - rank(b))) {
      if (line === held) held = null;
      else this.group.insertBefore(line, held);
    }
  }
}
