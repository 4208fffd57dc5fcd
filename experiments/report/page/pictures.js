"use strict";
// Pictures that prefplan has drawn, and what moves in them: automata, plans on graphs, and plans on maps.

const WIDE = 430; // pixels; a wider automaton gets a row of its own
const GRAPH = "The coloured state is the current one. Thick arrows are the plan's actions, numbered in order; each arrow has its action and its cost.";

function pictureOf(id) {
  return document.getElementById(id).content.cloneNode(true);
}

// Light up parts of a picture, and bring the node among them into view.
function light(box, selector) {
  for (const part of box.querySelectorAll(".here")) part.classList.remove("here");
  for (const part of box.querySelectorAll(selector)) part.classList.add("here");
  bringIntoView(box, box.querySelector(".node.here"));
}

// A task: formula, automaton in its current state, and what was paid.
class TaskCard {
  constructor(task, plan) {
    this.task = task;
    this.account = plan.ledger.tasks[task.name];
    this.status = make("p", { class: "status" });
    this.box = scrollBox(`Automaton of ${task.shown}`, "automaton", pictureOf(`automaton-${task.name}`));
    const svg = this.box.querySelector("svg");
    const used = this.account.bought.map(({ words }) => make("li", {}, words));
    this.element = make("article", { class: svg && svg.getAttribute("width") > WIDE ? "task wide" : "task", "data-task": task.name, "aria-label": task.title },
      make("h4", {}, task.title), this.status, make("p", {}, make("code", {}, task.formula)), this.box,
      task.offers.length ? make("p", { class: "small" }, `Allowed: ${task.offers.join("; ")}.`) : null,
      used.length ? make("ul", { class: "used" }, ...used) : null);
  }

  show({ done }) {
    const { states, satisfied } = this.account, state = states && states[done];
    const words = state === null ? "skipped"
      : satisfied !== null && done >= satisfied ? "done"
      : state === this.task.dead ? "can no longer be done" : "open";
    const text = state === null ? words : `${words} · state ${state}`;
    if (this.status.textContent === text) return;
    this.status.textContent = text;
    this.element.dataset.status = words.split(" ")[0];
    light(this.box, `.q${state}${done && states ? `, .q${states[done - 1]}-q${state}` : ""}`);
  }
}

// A plan on a graph: the current state, and the arrows already taken.
class PlanGraph {
  constructor(plan) {
    this.plan = plan;
    this.words = plan.graph.note ? `${plan.graph.note} ${GRAPH}` : GRAPH;
    this.element = scrollBox(plan.graph.words, "automaton graph picture", pictureOf(`map-${plan.index}`));
  }

  show({ done }) {
    const node = this.plan.graph.at[done];
    if (node !== this.node) light(this.element, `.s${node}`);
    this.node = node;
  }
}

// A plan on a map: its path, the part already taken, and the robot.
class GridMap {
  constructor(map, plan) {
    this.element = make("div", { class: "picture" }, pictureOf(`map-${plan.index}`));
    const svg = this.element.querySelector("svg"), [columns, rows] = map.size;
    const [, , wide, high] = svg.getAttribute("viewBox").split(" ").map(Number);
    this.points = plan.path.map(([x, y]) => [((x + 0.5) * wide) / columns, ((rows - 0.5 - y) * high) / rows]);
    this.gone = draw("polyline", { class: "gone", points: "" });
    this.robot = draw("circle", { class: "robot", r: Math.min(Math.max((0.32 * wide) / columns, 2.5), 9) });
    svg.querySelector(".path").after(this.gone);
    svg.append(this.robot);
  }

  show({ done, share }) {
    const [x, y] = this.points[done], [u, v] = this.points[done + 1] || [x, y];
    const at = [x + share * (u - x), y + share * (v - y)];
    this.robot.setAttribute("cx", at[0]);
    this.robot.setAttribute("cy", at[1]);
    this.gone.setAttribute("points", [...this.points.slice(0, done + 1), at].map((point) => point.join(",")).join(" "));
  }
}
