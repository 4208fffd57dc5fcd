"use strict";
// Wishes: a slider for the largest value of each objective, and what the wishes cost in the other objectives.

function fill(words, values) {
  return words.replace(/{(\w+)}/g, (_, name) => values[name]);
}

class Wishes {
  // `listener` gets the rank of the largest value allowed on each axis, and the plans that exceed one.
  constructor(place, { words, axes, ranks }, listener) {
    Object.assign(this, { words, axes, ranks, listener });
    this.rows = axes.map((axis, k) => this.row(axis, k));
    this.said = make("p", { id: "wished", role: "status" });
    this.left = make("p", { class: "small" });
    this.drop = make("button", { type: "button" }, "Drop all wishes");
    this.drop.onclick = () => {
      this.rows.forEach(({ slider }) => { slider.value = slider.max; });
      this.update();
      this.rows[0].slider.focus();
    };
    place.append(...this.rows.map((row) => row.element), this.said, this.left, this.drop);
    this.update();
  }

  row({ name, values }, k) {
    const slider = make("input", { type: "range", id: `wish-${k}`, min: 0, max: values.length - 1, step: 1, value: values.length - 1, disabled: values.length < 2 });
    const shown = make("output", { for: slider.id });
    slider.oninput = () => this.update();
    return { slider, shown, element: make("div", { class: "wish" }, make("label", { for: slider.id }, name), shown, slider) };
  }

  // The least value of an objective among some plans, as a rank; Infinity for no plan.
  least(k, plans) {
    return Math.min(...plans.map((plan) => plan[k]));
  }

  within(bounds, plans = this.ranks) {
    return plans.filter((plan) => plan.every((at, k) => at <= bounds[k]));
  }

  sentence(bounds) {
    const { axes, words, ranks } = this, left = this.within(bounds);
    const wished = axes.map((_, k) => k).filter((k) => bounds[k] < axes[k].values.length - 1);
    if (!wished.length) return words.none;
    const wishes = wished.map((k) => fill(words.wish, { name: axes[k].name, value: axes[k].texts[bounds[k]] })).join(", ");
    if (!left.length) return this.conflict(bounds, wished, wishes);
    const rises = axes.map((_, k) => [k, this.least(k, ranks), this.least(k, left)]).filter(([, least, rest]) => rest > least)
      .map(([k, least, rest]) => fill(words.rise, { name: axes[k].name, least: axes[k].texts[least], rest: axes[k].texts[rest] }));
    return rises.length ? fill(words.cost, { wishes, rises: rises.join(", ") }) : fill(words.free, { wishes });
  }

  // If no plan is left: the tightest limit possible for each objective while the other wishes stay.
  conflict(bounds, wished, wishes) {
    const { axes, words } = this;
    const alone = wished.map((k) => [k, this.least(k, this.within(bounds.map((bound, j) => (j === k ? Infinity : bound))))])
      .filter(([, rest]) => rest < Infinity).map(([k, rest]) => fill(words.alone, { name: axes[k].name, rest: axes[k].texts[rest] }));
    return fill(words.conflict, { wishes }) + (alone.length ? ` ${fill(words.instead, { alone: alone.join(", ") })}` : "");
  }

  update() {
    const bounds = this.rows.map(({ slider }) => Number(slider.value));
    this.rows.forEach(({ slider, shown }, k) => {
      const { values, texts } = this.axes[k], free = bounds[k] === values.length - 1;
      shown.textContent = free ? `any (${[...new Set([texts[0], texts[bounds[k]]])].join(" to ")})` : `at most ${texts[bounds[k]]}`;
      slider.setAttribute("aria-valuetext", shown.textContent);
    });
    const left = new Set(this.within(bounds)), all = this.ranks.length;
    this.said.textContent = this.sentence(bounds);
    this.left.textContent = fill(this.words.left, { left: left.size, all });
    this.drop.disabled = bounds.every((bound, k) => bound === this.axes[k].values.length - 1);
    this.listener(bounds, new Set([...this.ranks.keys()].filter((i) => !left.has(this.ranks[i]))));
  }
}
