"use strict";
// The Pareto front as a chart: a step line, and points that can be chosen by mouse, touch and keyboard.

const LETTER = 8; // width of a digit, pixels
const BESIDE_CHART = 80; // width of the axis beside it, pixels
const LABELLED = 14; // most points that show their numbers

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Select the ascending values whose labels, `size` pixels long, fit on an axis of `length` pixels; the ends come first.
function labelledOf(values, size, length) {
  const ends = [values[0], values[values.length - 1]], least = (size * (ends[1] - ends[0])) / length;
  const kept = [];
  for (const value of [...ends, ...values]) {
    if (kept.every((other) => Math.abs(value - other) >= least && value !== other)) kept.push(value);
  }
  return kept;
}

// Ticks stand only at values that occur; labels are exact, and left out where they would overlap.
function axisOf(values, title, style, size, length) {
  const distinct = [...new Set(values)].sort((a, b) => a - b);
  const low = distinct[0], high = distinct[distinct.length - 1], margin = 0.07 * (high - low) || 1;
  const labels = JSON.stringify(labelledOf(distinct, size, length / 1.14));
  return {
    type: "quantitative", title,
    scale: { zero: false, nice: false, domain: [low - margin, high + margin] },
    axis: {
      ...style, values: distinct, labelOverlap: "greedy", labelSeparation: 4,
      labelExpr: `indexof(${labels}, datum.value) < 0 ? '' : '' + round(datum.value * 1e6) / 1e6`,
      labelBound: false, grid: distinct.length <= LABELLED,
    },
  };
}

// What a plan is worth, in words.
function worthOf(plan) {
  if (!plan.worth) return `Cost ${show(plan.cost)}, penalty ${show(plan.preference)}`;
  return plan.worth.map(([name, value]) => `${name} ${show(value)}`).join(", ");
}

// The points that no other beats in the two objectives shown, by ascending values of the first.
function borderOf(values) {
  let least = Infinity;
  const rising = [...values].sort((a, b) => a.cost - b.cost || a.preference - b.preference);
  return rising.filter((value) => value.preference < least && ((least = value.preference), true));
}

// `objectives`: the names of the two that are shown, or null for cost and penalty.
function frontSpec(plans, unit, objectives, width, height) {
  const ink = colour("--ink"), soft = colour("--soft"), line = colour("--line");
  const first = colour("--first"), second = colour("--second"), paper = colour("--paper");
  const many = plans.length > LABELLED;
  const of = (plan, k) => plan.worth.find(([name]) => name === objectives[k])[1];
  const values = plans.map((plan) => ({
    index: plan.index,
    cost: objectives ? of(plan, 0) : plan.cost,
    preference: objectives ? of(plan, 1) : plan.preference,
    words: `Plan ${plan.index}: ${worthOf(plan).replace("Cost", "cost")}`,
  }));
  const style = { labelColor: soft, titleColor: ink, gridColor: line, domainColor: soft, tickColor: soft };
  const costs = values.map((value) => value.cost), preferences = values.map((value) => value.preference);
  const titles = objectives ? [`${objectives[0]} →`, `← ${objectives[1]} (lower is better)`]
    : [`Total cost${unit ? ` (${unit})` : ""} →`, "← Penalty (lower is better)"];
  const longest = Math.max(...costs.map((cost) => show(cost).length));
  const x = { field: "cost", ...axisOf(costs, titles[0], style, 8 + LETTER * longest, width) };
  const y = { field: "preference", ...axisOf(preferences, titles[1], style, LETTER * 2, height) };
  const tests = [
    { test: "datum.index === chosen", value: first },
    { test: "datum.index === other", value: second },
  ];
  return {
    width: "container", height, background: "transparent", data: { values },
    description: `The Pareto front: ${plans.length} plans, ${objectives ? objectives.join(" against ") : "cost against penalty"}.`,
    params: [{ name: "chosen", value: -1 }, { name: "other", value: -1 }, { name: "beyond", value: [] }],
    config: { view: { stroke: null }, font: getComputedStyle(document.body).fontFamily, axis: { labelFontSize: 12, titleFontSize: 13, titleFontWeight: 600 } },
    layer: [
      { data: { values: borderOf(values) }, mark: { type: "line", interpolate: "step-after", color: soft, strokeWidth: 1.5, aria: false }, encoding: { x, y } },
      {
        mark: { type: "point", filled: true, cursor: "pointer", strokeWidth: 2 },
        encoding: {
          x, y,
          shape: { condition: { test: "datum.index === other", value: "square" }, value: "circle" },
          size: { condition: { test: "datum.index === chosen || datum.index === other", value: 320 }, value: many ? 90 : 190 },
          color: { condition: tests, value: paper },
          stroke: { condition: tests, value: ink },
          opacity: { condition: { test: "indexof(beyond, datum.index) >= 0", value: 0.2 }, value: 1 },
          description: { field: "words" },
          tooltip: { field: "words" },
        },
      },
      {
        mark: { type: "text", dy: -18, dx: 8, fontSize: 13, fontWeight: 600, color: ink, aria: false, clip: false },
        encoding: {
          x, y, text: { field: "index" },
          opacity: { condition: { test: `${!many} || datum.index === chosen || datum.index === other`, value: 1 }, value: 0 },
        },
      },
    ],
  };
}

class FrontChart {
  // `unit`: what costs were measured in, or null.
  constructor(place, plans, unit, choose) {
    this.place = place;
    this.unit = unit;
    this.plans = plans;
    this.choose = choose;
    this.chosen = [-1, -1];
    this.beyond = [];
    this.view = null;
    this.axes = ["across", "up"].map((id) => document.getElementById(id)).filter(Boolean);
    for (const axis of this.axes) axis.onchange = () => { this.queue = this.queue.then(() => this.draw()); };
    this.queue = this.draw();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.queue = this.queue.then(() => this.draw()); });
  }

  async draw() {
    if (this.view) this.view.finalize();
    const spec = frontSpec(this.plans, this.unit, this.axes.length ? this.axes.map((axis) => axis.value) : null, this.place.clientWidth - BESIDE_CHART, matchMedia("(max-width: 600px)").matches ? 240 : 320);
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const { view } = await vegaEmbed(this.place, spec, { actions: false, renderer: "svg", tooltip: { theme: dark ? "dark" : "light" } });
    this.view = view;
    view.addEventListener("click", (event, item) => this.take(event, item && item.datum));
    view.addResizeListener(() => setTimeout(() => this.prepare(), 0));
    await this.mark();
  }

  take(event, datum) {
    if (datum && datum.index !== undefined) this.choose(datum.index, event.shiftKey);
  }

  // Vega draws the points; make buttons of them.
  prepare() {
    const svg = this.place.querySelector("svg");
    svg.setAttribute("role", "group");
    for (const point of svg.querySelectorAll("path[aria-roledescription]")) {
      const datum = point.__data__ && point.__data__.datum;
      if (!datum || datum.words === undefined) continue;
      point.setAttribute("tabindex", "0");
      point.setAttribute("role", "button");
      point.dataset.plan = datum.index;
      point.setAttribute("aria-pressed", String(this.chosen.includes(datum.index)));
      if (point.onkeydown) continue;
      point.onkeydown = (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        event.stopPropagation();
        this.take(event, point.__data__.datum);
      };
    }
  }

  async mark() {
    await this.view.signal("chosen", this.chosen[0]).signal("other", this.chosen[1]).signal("beyond", this.beyond).runAsync();
    this.prepare();
  }

  show(chosen, other) {
    this.chosen = [chosen, other === null ? -1 : other];
    this.queue = this.queue.then(() => this.mark());
  }

  // Grey out the plans that exceed a wish.
  wish(beyond) {
    this.beyond = [...beyond];
    this.queue = this.queue.then(() => this.mark());
  }
}
