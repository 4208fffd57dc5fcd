"use strict";
// One plan in full: video or map, why it costs what it costs, timeline, tasks and checks.

const AUTOMATA = "A circle is a state; the coloured one is the current state. A double ring means done, a dashed ring that the task "
  + "can no longer be done. An arrow is taken when its label holds: ! not, & and, | or. In formulas F is eventually, U until, X next.";
const MAP = "A dot with a name: a task is done there. A dot without a name: the start.";

class Panel {
  // `other`: the plan it is compared with, or null; `part`: number of equal actions at the start of both.
  constructor(data, plan, { other, part, most, side, seek, pictures }) {
    this.plan = plan;
    this.video = this.makeVideo(plan);
    this.scene = pictures.view(plan);
    this.map = data.map ? new GridMap(data.map, plan) : plan.graph ? new PlanGraph(plan) : null;
    this.caption = make("p", { class: "caption" });
    const timeline = new Timeline(plan, ordered(data.tasks, plan), {
      most, seek, part: other ? plan.ledger.spent[part] : null,
    });
    const cards = data.tasks.map((task) => new TaskCard(task, plan));
    this.followers = [timeline, this.map, this.scene].filter(Boolean);
    this.cards = cards;
    const title = make("h3", {}, make("span", { class: "badge" }, String(plan.index)),
      ` ${worthOf(plan)}`,
      plan.rank ? make("span", { class: "rank" }, plan.rank) : null);
    const [first, ...others] = this.explanations(plan, other);
    const shown = [this.video, this.scene && this.scene.element, this.map && this.map.element].filter(Boolean);
    this.view = make("article", { class: `panel view ${side}${shown.length ? "" : " bare"}`, "data-plan": plan.index, "aria-label": `Plan ${plan.index}` },
      title,
      make("p", { class: "headline" }, first.headline),
      make("div", { class: "watch" }, ...shown, this.caption, this.map ? make("p", { class: "small" }, this.map.words || MAP) : null, this.videoNote(plan)),
      timeline.element);
    this.element = make("article", { class: `panel more ${side}`, "data-plan": plan.index, "aria-label": `Plan ${plan.index} in detail` },
      make("h3", {}, make("span", { class: "badge" }, String(plan.index)), ` Plan ${plan.index}`),
      make("div", { class: "why" }, this.details(first, true),
        ...others.map((explanation) => make("div", {}, make("p", { class: "headline" }, explanation.headline), this.details(explanation, false)))),
      this.costs(data.tasks, plan),
      make("h4", { class: "part-title" }, "The tasks and their automata"),
      make("div", { class: "tasks" }, make("p", { class: "small key" }, AUTOMATA), ...cards.map((card) => card.element)),
      this.steps(data.tasks, plan, seek), this.certificate(plan));
  }

  makeVideo(plan) {
    if (!plan.run || !plan.run.video) return null;
    return make("video", {
      src: plan.run.video, preload: "auto", playsinline: true, muted: true,
      "aria-label": `Video of the robot carrying out plan ${plan.index}`,
    });
  }

  videoNote(plan) {
    const { run } = plan;
    if (!run) return this.map ? null : make("p", { class: "small" }, "This plan was not carried out; every action is shown for one second.");
    const notes = [];
    if (!run.video) notes.push(run.no_video ? `No video: ${run.no_video}` : "Carried out without a video; times are those of the run.");
    if (!run.completed) notes.push(`The run was not completed: ${run.reason}. The page shows what happened.`);
    else if (!run.as_planned) notes.push(`The run did not go as planned; the arm planned again ${run.replans === 1 ? "once" : `${run.replans} times`}. The page shows what happened.`);
    return notes.length ? make("p", { class: "notice" }, notes.join(" ")) : null;
  }

  // Why it costs more than the plan it is compared with, if that is cheaper, or else than its neighbour and the cheapest.
  explanations(plan, other) {
    const against = (index) => plan.explanations.filter((explanation) => explanation.against === index);
    const compared = other ? against(other.index) : [];
    const shown = compared.length ? compared : [...new Set([plan.index - 1, 0])].flatMap(against);
    return plan.index ? shown : plan.explanations;
  }

  details(explanation, open) {
    return make("details", { open, class: "explanation" },
      make("summary", {}, "Differences"),
      make("ul", {}, ...explanation.details.map((detail) => make("li", {}, detail))));
  }

  costs(tasks, plan) {
    const shared = plan.shares.length > 0;
    const rows = ordered(tasks, plan).map((task) => {
      const mine = plan.shares.filter((share) => share.task === task.name);
      const place = plan.order.indexOf(task.name);
      const position = place < 0 ? "not done" : ordinal(place);
      const adds = mine.reduce((sum, share) => sum + share.adds, 0);
      return make("tr", {},
        make("th", { scope: "row" }, task.title),
        make("td", {}, show(plan.task_costs[task.name])),
        make("td", {}, position),
        shared ? make("td", {}, mine.map((share) => share.preferred).join("; ") || "–") : null,
        shared ? make("td", { class: adds ? "adds" : null }, show(adds)) : null);
    });
    const heads = ["Task", "Done at cost", "Position", ...(shared ? ["Preferred", "Adds to penalty"] : [])];
    return scrollBox(`Costs of the tasks in plan ${plan.index}`, "", make("table", { class: "costs" },
      make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, head)))),
      make("tbody", {}, ...rows)));
  }

  steps(tasks, plan, seek) {
    const { actions, costs, spent, tasks: accounts } = plan.ledger;
    const rows = actions.map((action, k) => {
      const news = tasks.flatMap(({ name, shown }) => {
        const account = accounts[name];
        if (account.states === null) return [];
        const bought = account.bought.filter((one) => one.step === k + 1).map((one) => `${shown}: ${one.assume} counts as true, for ${one.cost}`);
        if (account.satisfied === k + 1) return [...bought, `${shown} is done`];
        return account.advances.includes(k + 1) ? [...bought, `${shown} changes to state ${account.states[k + 1]}`] : bought;
      });
      const go = make("button", { type: "button", class: "link" }, MOVES[action] || action);
      go.addEventListener("click", () => seek(plan.times[k][0]));
      return make("tr", {}, make("td", {}, String(k + 1)), make("td", {}, go), make("td", {}, costs[k]), make("td", {}, show(spent[k + 1])), make("td", {}, news.join("; ")));
    });
    return make("details", { class: "steps" },
      make("summary", {}, actions.length ? `All ${actions.length} actions, one by one` : "There is nothing to do"),
      scrollBox(`Actions of plan ${plan.index}`, "", make("table", {},
        make("thead", {}, make("tr", {}, ...["#", "Action", "Costs", "Spent", "Tasks"].map((head) => make("th", { scope: "col" }, head)))),
        make("tbody", {}, ...rows))));
  }

  certificate(plan) {
    const proof = plan.run ? plan.run.certificate : null;
    const checks = proof ? proof.checks : plan.checks;
    const refuted = checks.filter((check) => !check.holds).length;
    const what = proof ? "checks of the run’s log" : "checks of the plan by its definitions";
    const verdict = refuted ? `Not certified: ${refuted} of ${checks.length} ${what} fail` : `Certified: ${checks.length} ${what} hold`;
    const lists = [this.checkList(checks)];
    if (proof) {
      lists.push(make("p", { class: "small" }, "Check it again: ", make("code", {}, `prefplan verify ${plan.run.log}`), " (in this folder). ",
        make("a", { href: plan.run.log, download: true }, "The log"), "."));
      const failed = plan.checks.filter((check) => !check.holds).length;
      lists.push(make("p", { class: "small" }, failed ? `${failed} checks of the plan itself fail:` : `${plan.checks.length} checks of the plan itself hold:`), this.checkList(plan.checks));
    }
    return make("details", { class: `certificate ${refuted ? "refuted" : "confirmed"}` }, make("summary", {}, verdict), ...lists);
  }

  checkList(checks) {
    return make("ul", { class: "checks" }, ...checks.map((check) => make("li", { class: check.holds ? "holds" : "fails" },
      make("span", { "aria-hidden": "true" }, check.holds ? "✓ " : "✗ "), make("span", { class: "hidden" }, check.holds ? "holds: " : "fails: "),
      make("b", {}, check.name), ` ${check.words}`)));
  }

  show(time) {
    const { done, now, spent } = progress(this.plan, time);
    for (const follower of this.followers) follower.show(time);
    for (const card of this.cards) card.show(done);
    const { actions } = this.plan.ledger;
    const action = now === null ? (actions.length ? "the end" : "nothing to do") : `${now + 1} of ${actions.length}: ${MOVES[actions[now]] || actions[now]}`;
    const words = `${action} · spent ${show(Math.round(spent * 10) / 10)} of ${show(this.plan.ledger.spent[actions.length])}`;
    if (words !== this.words) this.caption.textContent = this.words = words;
  }
}

// The tasks in the preferred order; the others in the order of the scenario.
function ordered(tasks, plan) {
  const preferred = plan.shares.map((share) => share.task);
  const rank = (task) => (preferred.includes(task.name) ? preferred.indexOf(task.name) : tasks.length);
  return [...tasks].sort((a, b) => rank(a) - rank(b));
}

function ordinal(place) {
  const words = ["first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth"];
  return words[place] || `${place + 1}th`;
}
