"use strict";
// Wishes: a slider for the largest value of each objective, and what the wishes cost in the other objectives.

class Wishes {
  // `listener` gets the rank of the largest value allowed on each axis, and the plans that exceed one.
  constructor(place, { axes, ranks, complete }, listener) {
    Object.assign(this, { axes, ranks, complete, listener });
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

  within(bounds) {
    return this.ranks.filter((plan) => plan.every((at, k) => at <= bounds[k]));
  }

  // What the wishes cost, in words that are true also of the plans found by a search that was not completed.
  sentence(bounds, wished, left) {
    const { axes, ranks, complete } = this;
    if (!wished.length) return "No wish yet: move a slider to the left.";
    const wishes = wished.map((k) => `${axes[k].name} at most ${axes[k].texts[bounds[k]]}`).join(", ");
    if (!left.length) return this.conflict(bounds, wished, wishes);
    const rises = axes.map(({ name, texts }, k) => [name, texts, this.least(k, ranks), this.least(k, left)])
      .filter(([, , least, rest]) => rest > least)
      .map(([name, texts, least, rest]) => `${name} from ${texts[least]} to ${complete ? "at least " : ""}${texts[rest]}`);
    if (rises.length) return `${wishes}${complete ? "" : ", among the plans found"}: ${rises.join(", ")}.`;
    return `${wishes}: every other objective ${complete ? "can still have its least" : "has its least among the plans found"}.`;
  }

  // If no plan is left: the tightest limit possible for each objective while the other wishes stay.
  conflict(bounds, wished, wishes) {
    const { axes, complete } = this;
    const alone = wished.map((k) => [axes[k], this.least(k, this.within(bounds.map((bound, j) => (j === k ? Infinity : bound))))])
      .filter(([, rest]) => rest < Infinity)
      .map(([{ name, texts }, rest]) => `${name} is ${complete ? `at least ${texts[rest]}` : `${texts[rest]} among the plans found`}`);
    const instead = alone.length ? ` With the other wishes, ${alone.join(", ")}.` : "";
    return `${complete ? "No plan" : "None of the plans found"} has ${wishes} at once.${instead}`;
  }

  update() {
    const bounds = this.rows.map(({ slider }) => Number(slider.value)), left = this.within(bounds), kept = new Set(left);
    const wished = [...bounds.keys()].filter((k) => bounds[k] < this.axes[k].values.length - 1);
    this.rows.forEach(({ slider, shown }, k) => {
      const { texts } = this.axes[k], most = texts[bounds[k]];
      shown.textContent = wished.includes(k) ? `at most ${most}` : `any (${[...new Set([texts[0], most])].join(" to ")})`;
      slider.setAttribute("aria-valuetext", shown.textContent);
    });
    this.said.textContent = this.sentence(bounds, wished, left);
    this.left.textContent = `${left.length} of ${this.ranks.length} plans left.`;
    this.drop.disabled = !wished.length;
    this.listener(bounds, new Set([...this.ranks.keys()].filter((i) => !kept.has(this.ranks[i]))));
  }
}
