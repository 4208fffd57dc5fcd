"use strict";
// A plan as a timeline: along the cost spent, a bar for every action, and below it the progress of every task.

// The kinds of actions, as many as there are moves, and colours in style.css.
const KINDS = ["transit", "grasp", "transport", "release"];
const MOVES = { N: "north", E: "east", S: "south", W: "west" };

function kindOf(action, actions) {
  const place = [...KINDS, ...Object.keys(MOVES)].indexOf(action.split(" ")[0]);
  return (place < 0 ? [...new Set(actions)].indexOf(action) : place) % 4;
}

// The progress of a plan at a time: number of actions done, the one under way (or null), its share, and the cost spent.
function progress(plan, time) {
  const { spent } = plan.ledger, done = plan.times.filter(([, end]) => end <= time + 1e-6).length;
  if (done === plan.times.length) return { done, now: null, share: 0, spent: spent[done] };
  const [start, end] = plan.times[done];
  const share = Math.max(0, Math.min(1, (time - start) / Math.max(end - start, 1e-9)));
  return { done, now: done, share, spent: spent[done] + share * (spent[done + 1] - spent[done]) };
}

function holds(bar) {
  const words = bar.firstElementChild;
  return words.scrollWidth <= bar.clientWidth && words.scrollHeight <= bar.clientHeight;
}

class Timeline {
  // `most`: cost at the right end; `part`: cost at the first difference of two compared plans, or null.
  constructor(plan, tasks, { most, part, seek }) {
    const { actions, costs, spent, tasks: accounts } = plan.ledger;
    this.plan = plan;
    this.most = most || 1;
    this.bars = actions.map((action, k) => {
      const words = `Action ${k + 1} of ${actions.length}: ${MOVES[action] || action}, costs ${costs[k]}, ${show(spent[k + 1])} spent after it`;
      const bar = make("button", {
        type: "button", class: `bar kind-${kindOf(action, actions)}`, title: words, "aria-label": words, "data-action": k,
        style: `left:${this.at(spent[k])};width:${this.at(spent[k + 1] - spent[k])}`,
      }, make("span", {}, action));
      bar.addEventListener("click", () => seek(plan.times[k][0]));
      return bar;
    });
    walkable(this.bars, (k) => seek(plan.times[k][0]));
    this.head = make("div", { class: "playhead", "aria-hidden": "true" });
    const lanes = tasks.map((task) => this.lane(task, accounts[task.name], spent));
    const line = part === null ? null : make("div", { class: "part-line", style: `left:${this.at(part)}`, title: "The first difference of the plans" });
    const bars = make("div", { class: "bars", role: "group", "aria-label": "Actions; arrow keys go along them" }, ...this.bars);
    new ResizeObserver(() => this.fit()).observe(bars);
    this.element = make("div", { class: "timeline", role: "group", "aria-label": `Timeline of plan ${plan.index}` },
      make("div", { class: "track" }, this.scale(), bars, ...lanes, line, this.head),
      this.legend(actions, accounts));
  }

  legend(actions, accounts) {
    const kinds = KINDS.filter((kind) => actions.some((action) => action.startsWith(`${kind} `)));
    const chips = kinds.map((kind) => make("span", {}, make("span", { class: `chip kind-${KINDS.indexOf(kind)}` }), ` ${kind}`));
    const paid = Object.values(accounts).some((account) => account.bought.length);
    return make("p", { class: "small legend" }, ...chips, make("span", {}, `○ task advances · ✓ done${paid ? " · $ relaxed" : ""}`));
  }

  // Label each bar with as much as it has space for: the action, or what it acts on, along the bar or upright.
  fit() {
    const { actions } = this.plan.ledger;
    const labels = actions.map((action) => [action, action.split(" ")[1] || action]);
    let left = this.bars.map((_, k) => k);
    for (const [which, upright] of [[0, false], [1, false], [0, true], [1, true]]) {
      for (const k of left) {
        this.bars[k].classList.remove("narrow");
        this.bars[k].classList.toggle("upright", upright);
        this.bars[k].firstElementChild.textContent = labels[k][which];
      }
      left = left.filter((k) => !holds(this.bars[k]));
    }
    for (const k of left) this.bars[k].classList.add("narrow");
  }

  at(cost) {
    return `${(100 * cost) / this.most}%`;
  }

  scale() {
    const whole = this.plan.ledger.spent.every(Number.isInteger);
    const raw = Math.max(this.most / 5, whole ? 1 : 0), power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw) || raw;
    const ticks = [];
    for (let cost = 0; cost <= this.most * 1.0001; cost += step) ticks.push(make("span", { style: `left:${this.at(cost)}` }, show(cost)));
    return make("div", { class: "scale", "aria-hidden": "true" }, ...ticks);
  }

  lane(task, account, spent) {
    const { states, satisfied, advances, bought } = account, open = satisfied === null;
    const end = spent[open ? spent.length - 1 : satisfied];
    const words = states === null ? "skipped" : open ? "not done" : `done at ${show(end)}`;
    const mark = (kind, k, title, sign) => make("span", { class: kind, style: `left:${this.at(spent[k])}`, title }, sign);
    const marks = [
      ...advances.filter((k) => k !== satisfied).map((k) => mark("advance", k, `After action ${k} its automaton is in state ${states[k]}`, "")),
      ...bought.map((one) => mark(advances.includes(one.step) || satisfied === one.step ? "bought beside" : "bought", one.step, one.words, "$")),
      ...(open ? [] : [mark("done", satisfied, words, "✓")])];
    return make("div", { class: "lane", "data-task": task.name },
      make("div", { class: "lane-name" }, make("b", {}, task.title), ` ${words}`),
      make("div", { class: "lane-line" }, make("div", { class: `lane-fill${open ? " open" : ""}`, style: `width:${this.at(end)}` }), ...marks));
  }

  show({ now, spent }) {
    this.head.style.left = this.at(spent);
    this.bars.forEach((bar, k) => bar.classList.toggle("now", k === now));
  }
}
