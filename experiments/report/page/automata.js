"use strict";
// The tasks: formula, automaton in its current state, and what was paid.

const WIDE = 430; // pixels; a wider automaton gets a row of its own

class TaskCard {
  constructor(task, plan) {
    this.task = task;
    this.account = plan.ledger.tasks[task.name];
    this.plan = plan;
    const picture = document.getElementById(`automaton-${task.name}`).content.cloneNode(true);
    this.status = make("p", { class: "status" });
    const offers = task.offers.length ? make("p", { class: "small" }, `Allowed: ${task.offers.join("; ")}.`) : null;
    const used = this.account.bought.map((bought) => make("li", {}, bought.assume === null
      ? `Skipped, for ${bought.cost}`
      : `${bought.assume} counts as true ${bought.step ? `after action ${bought.step}` : "at the start"}, for ${bought.cost}`));
    const svg = picture.querySelector("svg"), width = svg ? Number(svg.getAttribute("width")) : 0;
    if (svg) svg.style.setProperty("--natural", `${width}px`);
    this.box = scrollBox(`Automaton of ${task.shown}`, "automaton", picture);
    this.element = make("article", { class: width > WIDE ? "task wide" : "task", "data-task": task.name },
      make("h4", {}, task.title), this.status,
      make("p", {}, make("code", {}, task.formula)),
      this.box,
      offers, used.length ? make("ul", { class: "used" }, ...used) : null);
  }

  show(done) {
    const { states, satisfied } = this.account;
    const state = states === null ? null : states[done];
    const words = state === null ? "skipped"
      : satisfied !== null && done >= satisfied ? "done"
      : state === this.task.dead ? "can no longer be done" : "open";
    if (this.shown === `${state} ${words}`) return;
    this.shown = `${state} ${words}`;
    this.status.textContent = state === null ? words : `${words} · state ${state}`;
    this.element.dataset.status = words.split(" ")[0];
    for (const part of this.box.querySelectorAll(".here")) part.classList.remove("here");
    const entered = done && states && states[done - 1] !== state ? `, .q${states[done - 1]}-q${state}` : "";
    for (const part of this.box.querySelectorAll(`.q${state}${entered}`)) part.classList.add("here");
    bringIntoView(this.box, this.box.querySelector(".node.here"));
  }
}
