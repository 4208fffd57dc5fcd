"use strict";
// The page: which plans are shown, and the controls that play them.

(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { plans } = data;
  const byId = (id) => document.getElementById(id);
  const clock = new Clock(() => update());
  const wanted = new URLSearchParams(location.hash.slice(1));
  const pictures = new Pictures(byId("pictures"), data, { choose: showPictures, update, inScene: wanted.has("3d") });
  let chosen = 0, other = null, panels = [];
  const choose = (index, compare) => (compare ? select(chosen, index) : select(index, other));
  const titles = data.objectives ? null : [`Total cost${data.cost_unit ? ` (${data.cost_unit})` : ""}`, "Penalty"];
  const charts = [new FrontChart(byId("chart"), data, titles, choose)];
  if (data.words) charts.push(new ParallelCoordinates(byId("parallel"), data, choose));

  function select(plan, against) {
    chosen = plan;
    other = against === plan ? null : against;
    const one = plans[chosen], two = other === null ? null : plans[other];
    const shown = two ? [one, two] : [one];
    const part = two ? common(one.ledger.actions, two.ledger.actions) : null;
    const most = Math.max(...shown.map((p) => p.ledger.spent[p.ledger.spent.length - 1]));
    panels = shown.map((p, i) => new Panel(data, p, { other: i ? one : two, part, most, side: i ? "second" : "first", seek, pictures }));
    for (const [id, partOf] of [["views", (panel) => panel.view], ["panels", (panel) => panel.element]]) {
      byId(id).replaceChildren(...panels.map(partOf));
      byId(id).classList.toggle("two", panels.length === 2);
    }
    byId("plan").textContent = two ? `Plans ${chosen} and ${other}` : `Plan ${chosen}`;
    tellParting(one, two, part);
    const duration = Math.max(...shown.map((p) => (p.times.length ? p.times[p.times.length - 1][1] : 0)));
    byId("scrub").max = String(duration || 1);
    clock.load(duration, []);
    showPictures();
    for (const row of byId("points").querySelectorAll("tbody tr")) {
      const index = Number(row.dataset.plan);
      row.classList.toggle("first", index === chosen);
      row.classList.toggle("second", index === other);
      row.querySelector(".choose").setAttribute("aria-pressed", String(index === chosen));
      row.querySelector(".compare").setAttribute("aria-pressed", String(index === other));
      row.querySelector(".compare").disabled = index === chosen;
    }
    for (const chart of charts) chart.show(chosen, other);
  }

  function wish(bounds, beyond) {
    for (const chart of charts) chart.wish(bounds, beyond);
    for (const row of byId("points").querySelectorAll("tbody tr")) row.classList.toggle("beyond", beyond.has(Number(row.dataset.plan)));
  }

  function showPictures() {
    const playing = clock.playing;
    for (const panel of panels) pictures.arrange(panel);
    const videos = panels.map((panel) => panel.video).filter((video) => video && !video.hidden);
    for (const video of videos) video.muted = true;
    clock.load(clock.duration, videos);
    clock.setRate(Number(byId("speed").value));
    if (playing) clock.play();
    history.replaceState(null, "", `#plan=${chosen}${other === null ? "" : `&with=${other}`}${pictures.inScene ? "&3d" : ""}`);
  }

  function common(one, two) {
    let k = 0;
    while (k < one.length && k < two.length && one[k] === two[k]) k += 1;
    return k;
  }

  // The first difference of two plans, in words and as a mark on the scrubber.
  function tellParting(one, two, part) {
    const words = byId("parting"), mark = byId("parting-mark");
    words.hidden = mark.hidden = !two;
    if (!two) return;
    const time = startOf(one, part);
    const does = (plan) => plan.ledger.actions[part] ? `plan ${plan.index} does ${MOVES[plan.ledger.actions[part]] ? `a move ${MOVES[plan.ledger.actions[part]]}` : plan.ledger.actions[part]}` : `plan ${plan.index} has ended`;
    const go = make("button", { type: "button", class: "link" }, "Go there");
    go.addEventListener("click", () => seek(time));
    const same = part ? `Both begin with the same ${part === 1 ? "action" : `${part} actions`} (cost ${show(one.ledger.spent[part])}). Then` : "They differ from the first action:";
    words.replaceChildren(`${same} ${does(one)}, and ${does(two)}. `, go);
    const whole = Math.max(startOf(one, Infinity), startOf(two, Infinity)) || 1;
    mark.style.left = `${(100 * time) / whole}%`;
  }

  function startOf(plan, k) {
    if (k < plan.times.length) return plan.times[k][0];
    return plan.times.length ? plan.times[plan.times.length - 1][1] : 0;
  }

  function seek(time) {
    clock.seek(time);
  }

  function step(by) {
    const starts = [...new Set(panels.flatMap((panel) => [...panel.plan.times.map(([start]) => start), startOf(panel.plan, Infinity)]))].sort((a, b) => a - b);
    const next = by > 0 ? starts.find((t) => t > clock.time + 1e-3) : starts.reverse().find((t) => t < clock.time - 1e-3);
    clock.pause();
    if (next !== undefined) seek(next);
  }

  function update() {
    for (const panel of panels) panel.show(clock.time);
    byId("scrub").value = String(clock.time);
    byId("time").textContent = `${clock.time.toFixed(1)} s of ${clock.duration.toFixed(1)} s`;
    byId("play").textContent = clock.playing ? "Pause" : "Play";
  }

  for (const box of document.querySelectorAll(".scroll")) watchEdges(box);
  byId("play").addEventListener("click", () => clock.toggle());
  byId("back").addEventListener("click", () => step(-1));
  byId("on").addEventListener("click", () => step(1));
  byId("scrub").addEventListener("input", (event) => seek(Number(event.target.value)));
  byId("speed").addEventListener("change", (event) => clock.setRate(Number(event.target.value)));
  byId("points").addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    const index = Number(button.closest("tr").dataset.plan);
    if (button.classList.contains("choose")) select(index, other);
    else select(chosen, other === index ? null : index);
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input, select, button, a, summary, [tabindex='0']:not(canvas)")) return;
    if (event.key === " ") clock.toggle();
    else if (event.key === "ArrowRight") step(1);
    else if (event.key === "ArrowLeft") step(-1);
    else return;
    event.preventDefault();
  });

  const known = (name) => (plans[Number(wanted.get(name))] && wanted.has(name) ? Number(wanted.get(name)) : null);
  const best = plans.length > 1 ? plans.length - 1 : null;
  select(known("plan") ?? 0, wanted.has("plan") ? known("with") : best);
  if (data.words) new Wishes(byId("wishes"), data, wish);
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (wanted.has("plan") || still) return;
  if (panels.some((panel) => panel.video || panel.map)) clock.play();
  else if (pictures.loading) pictures.loading.then((shown) => shown && clock.play());
})();
