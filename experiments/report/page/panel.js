"use strict";
// One plan in full: video or map, why it costs what it costs, timeline, tasks and checks.

const AUTOMATA = "A circle is a state; the coloured one is the current state. A double ring means done, a dashed ring that the task "
  + "can no longer be done. An arrow is taken when its label holds: ! not, & and, | or. In formulas F is eventually, U until, X next.";
const MAP = "The large dot is the start. At the small ones tasks are done, with their names where there is room.";

// A table with headings, in a box that scrolls; the cells of a row are `td` or `th` with their content.
function tableOf(name, kind, heads, rows) {
  return scrollBox(name, "", make("table", { class: kind },
    make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, head)))),
    make("tbody", {}, ...rows.map((cells) => make("tr", {}, ...cells)))));
}

class Panel {
  // `other`: the plan it is compared with, or null; `part`: number of equal actions at the start of both.
  constructor(data, plan, { other, part, most, side, seek, update }) {
    Object.assign(this, { plan, seek, side });
    this.video = plan.run && plan.run.video ? make("video", {
      src: plan.run.video, preload: "auto", playsinline: true, muted: true,
      "aria-label": `Video of the robot carrying out plan ${plan.index}`,
    }) : null;
    this.scene = plan.run && data.scene ? new SceneView(plan, update) : null;
    this.map = data.map ? new GridMap(data.map, plan) : plan.graph ? new PlanGraph(plan) : null;
    this.caption = make("p", { class: "caption" });
    // The tasks in the preferred order; the others in the order of the scenario.
    const preferred = plan.shares.map((share) => share.task), rank = ({ name }) => (preferred.includes(name) ? preferred.indexOf(name) : data.tasks.length);
    this.tasks = [...data.tasks].sort((a, b) => rank(a) - rank(b));
    const timeline = new Timeline(plan, this.tasks, { most, seek, part: other ? plan.ledger.spent[part] : null });
    const cards = data.tasks.map((task) => new TaskCard(task, plan));
    this.followers = [timeline, this.map, this.scene, ...cards].filter(Boolean);
    const [first, ...others] = this.explanations(other);
    const shown = [this.video, this.scene && this.scene.element, this.map && this.map.element].filter(Boolean);
    this.view = this.article(shown.length ? "view" : "view bare", `Plan ${plan.index}`,
      [` ${plan.worth.replace(/^cost/, "Cost")}`, plan.rank ? make("span", { class: "rank" }, plan.rank) : ""],
      make("p", { class: "headline" }, first.headline),
      make("div", { class: "watch" }, ...shown, this.caption, this.map ? make("p", { class: "small" }, this.map.words || MAP) : null, this.note()),
      timeline.element);
    this.element = this.article("more", `Plan ${plan.index} in detail`, [` Plan ${plan.index}`],
      make("div", { class: "why" }, this.details(first, true),
        ...others.map((explanation) => make("div", {}, make("p", { class: "headline" }, explanation.headline), this.details(explanation, false)))),
      this.costs(),
      make("h4", { class: "part-title" }, "The tasks and their automata"),
      make("div", { class: "tasks" }, make("p", { class: "small key" }, AUTOMATA), ...cards.map((card) => card.element)),
      this.steps(data.tasks), this.certificate());
  }

  article(kind, name, title, ...parts) {
    return make("article", { class: `panel ${kind} ${this.side}`, "data-plan": this.plan.index, "aria-label": name },
      make("h3", {}, make("span", { class: "badge" }, String(this.plan.index)), ...title), ...parts);
  }

  // What else is to be known of the pictures, or null.
  note() {
    const { run } = this.plan, notes = [];
    if (!run) return this.map ? null : make("p", { class: "small" }, "This plan was not carried out; every action is shown for one second.");
    if (!run.video) notes.push(run.no_video ? `No video: ${run.no_video}` : "Carried out without a video; times are those of the run.");
    if (!run.completed) notes.push(`The run was not completed: ${run.reason}. The page shows what happened.`);
    else if (!run.as_planned) notes.push(`The run did not go as planned; the arm planned again ${run.replans === 1 ? "once" : `${run.replans} times`}. The page shows what happened.`);
    return notes.length ? make("p", { class: "notice" }, notes.join(" ")) : null;
  }

  // Why it costs more than the plan it is compared with, if that is cheaper, or else than its neighbour and the cheapest.
  explanations(other) {
    const { index, explanations } = this.plan, against = (cheaper) => explanations.filter((one) => one.against === cheaper);
    if (!index) return explanations;
    const compared = other ? against(other.index) : [];
    return compared.length ? compared : [...new Set([index - 1, 0])].flatMap(against);
  }

  details(explanation, open) {
    return make("details", { open, class: "explanation" },
      make("summary", {}, "Differences"),
      make("ul", {}, ...explanation.details.map((detail) => make("li", {}, detail))));
  }

  costs() {
    const { plan } = this, shared = plan.shares.length > 0;
    const rows = this.tasks.map(({ name, title }) => {
      const mine = plan.shares.filter((share) => share.task === name);
      const adds = mine.reduce((sum, share) => sum + share.adds, 0);
      const cells = [show(plan.task_costs[name]), plan.positions[name] ?? "not done"];
      if (shared) cells.push(mine.map((share) => share.preferred).join("; ") || "–");
      return [make("th", { scope: "row" }, title), ...cells.map((cell) => make("td", {}, cell)), ...(shared ? [make("td", { class: adds ? "adds" : null }, show(adds))] : [])];
    });
    return tableOf(`Costs of the tasks in plan ${plan.index}`, "costs", ["Task", "Done at cost", "Position", ...(shared ? ["Preferred", "Adds to penalty"] : [])], rows);
  }

  steps(tasks) {
    const { ledger: { actions, costs, spent }, index, times } = this.plan;
    const rows = actions.map((action, k) => {
      const go = make("button", { type: "button", class: "link" }, MOVES[action] || action);
      go.onclick = () => this.seek(times[k][0]);
      const news = tasks.flatMap((task) => this.news(task, k + 1)).join("; ");
      return [String(k + 1), go, costs[k], show(spent[k + 1]), news].map((cell) => make("td", {}, cell));
    });
    return make("details", { class: "steps" },
      make("summary", {}, actions.length ? `All ${actions.length} actions, one by one` : "There is nothing to do"),
      tableOf(`Actions of plan ${index}`, null, ["#", "Action", "Costs", "Spent", "Tasks"], rows));
  }

  // What an action changes for a task, in words.
  news({ name, shown }, step) {
    const { states, bought, satisfied, advances } = this.plan.ledger.tasks[name];
    if (states === null) return [];
    const found = bought.filter((one) => one.step === step).map(({ words }) => words);
    if (satisfied === step) return [...found, `${shown} is done`];
    return advances.includes(step) ? [...found, `${shown} changes to state ${states[step]}`] : found;
  }

  certificate() {
    const { run, checks } = this.plan, proof = run ? run.certificate : null, failing = (list) => list.filter((check) => !check.holds).length;
    const all = proof ? proof.checks : checks, refuted = failing(all);
    const what = proof ? "checks of the run’s log" : "checks of the plan by its definitions";
    const more = proof ? [
      make("p", { class: "small" }, "Check it again: ", make("code", {}, `prefplan verify ${run.log}`), " (in this folder). ", make("a", { href: run.log, download: true }, "The log"), "."),
      make("p", { class: "small" }, failing(checks) ? `${failing(checks)} checks of the plan itself fail:` : `${checks.length} checks of the plan itself hold:`),
      this.checkList(checks)] : [];
    return make("details", { class: `certificate ${refuted ? "refuted" : "confirmed"}` },
      make("summary", {}, refuted ? `Not certified: ${refuted} of ${all.length} ${what} fail` : `Certified: ${all.length} ${what} hold`),
      this.checkList(all), ...more);
  }

  checkList(checks) {
    return make("ul", { class: "checks" }, ...checks.map(({ holds, name, words }) => make("li", { class: holds ? "holds" : "fails" },
      make("span", { "aria-hidden": "true" }, holds ? "✓ " : "✗ "), make("span", { class: "hidden" }, holds ? "holds: " : "fails: "),
      make("b", {}, name), ` ${words}`)));
  }

  show(time) {
    const at = progress(this.plan, time), { now, spent } = at, { actions, spent: sums } = this.plan.ledger;
    for (const follower of this.followers) follower.show(at, time);
    const action = now === null ? (actions.length ? "the end" : "nothing to do") : `${now + 1} of ${actions.length}: ${MOVES[actions[now]] || actions[now]}`;
    const words = `${action} · spent ${show(Math.round(spent * 10) / 10)} of ${show(sums[actions.length])}`;
    if (words !== this.caption.textContent) this.caption.textContent = words;
  }
}
