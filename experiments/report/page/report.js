"use strict";
// The page: which plans are shown, and the controls that play them.

(() => {
  const data = JSON.parse(document.getElementById("data").textContent), { plans } = data;
  const byId = (id) => document.getElementById(id);
  const clock = new Clock(() => update());
  const wanted = new URLSearchParams(location.hash.slice(1));
  const rows = [...byId("points").querySelectorAll("tbody tr")].map((row) => [row, ...row.querySelectorAll("button")]);
  const in3d = byId("in-3d") || {}; // a run without a scene has none
  let chosen = 0, other = null, panels = [];
  let scenes = []; // for each 3-D scene, a promise whether there is something to see
  const choose = (index, compare) => (compare ? select(chosen, index) : select(index, other));
  const seek = (time) => clock.seek(time);
  in3d.checked = wanted.has("3d");
  if (in3d.labels && !plans.some(({ run }) => run && run.video)) in3d.labels[0].remove();
  const chart = new (data.axes.length === 2 ? FrontChart : ParallelCoordinates)(byId("chart"), data, choose);

  function select(plan, against) {
    chosen = plan;
    other = against === plan ? null : against;
    const one = plans[chosen], two = other === null ? null : plans[other], shown = two ? [one, two] : [one];
    const part = two ? partingOf(one.ledger.actions, two.ledger.actions) : null;
    const most = Math.max(...shown.map((p) => p.ledger.spent[p.ledger.spent.length - 1]));
    panels = shown.map((p, i) => new Panel(data, p, { other: i ? one : two, part, most, side: i ? "second" : "first", seek, update }));
    byId("views").replaceChildren(...panels.map((panel) => panel.view));
    byId("panels").replaceChildren(...panels.map((panel) => panel.element));
    byId("plan").textContent = two ? `Plans ${chosen} and ${other}` : `Plan ${chosen}`;
    const duration = Math.max(...shown.map(endOf));
    tellParting(one, two, part, duration);
    byId("scrub").max = String(duration || 1);
    clock.load(duration, []);
    showPictures();
    rows.forEach(([, take, compare], index) => {
      take.setAttribute("aria-pressed", String(index === chosen));
      compare.setAttribute("aria-pressed", String(index === other));
      compare.disabled = index === chosen;
    });
    chart.update({ chosen, other });
    bringToView(rows[chosen][0]);
  }

  // Scroll the table, but not the page, to one of its rows.
  function bringToView(row) {
    const box = row.closest(".scroll"), top = row.offsetTop - box.scrollTop;
    if (top < 0 || top + row.offsetHeight > box.clientHeight) box.scrollTop += top - box.clientHeight / 2;
  }

  function wish(bounds, beyond) {
    chart.update({ bounds, beyond });
    rows.forEach(([row], index) => row.classList.toggle("beyond", beyond.has(index)));
  }

  // Show the videos or the 3-D scenes of the runs; of a run without a video, its scene.
  function showPictures() {
    const { playing } = clock, inScene = in3d.checked, videos = panels.map(({ video }) => video).filter(Boolean);
    for (const video of videos) Object.assign(video, { hidden: inScene, muted: true });
    scenes = panels.filter(({ scene }) => scene).map(({ scene, video }) => scene.reveal(inScene || !video));
    clock.load(clock.duration, inScene ? [] : videos);
    if (playing) clock.play();
    history.replaceState(null, "", `#plan=${chosen}${other === null ? "" : `&with=${other}`}${inScene ? "&3d" : ""}`);
  }

  // The number of equal actions at the start of two plans.
  function partingOf(one, two) {
    const first = one.findIndex((action, k) => action !== two[k]);
    return first < 0 ? one.length : first;
  }

  // The first difference of two plans, in words and as a mark on the scrubber.
  function tellParting(one, two, part, duration) {
    const words = byId("parting"), mark = byId("parting-mark");
    words.hidden = mark.hidden = !two;
    if (!two) return;
    const time = part < one.times.length ? one.times[part][0] : endOf(one);
    const move = (action) => (MOVES[action] ? `a move ${MOVES[action]}` : action);
    const does = ({ index, ledger: { actions } }) => (part < actions.length ? `plan ${index} does ${move(actions[part])}` : `plan ${index} has ended`);
    const go = make("button", { type: "button", class: "link" }, "Go there");
    go.onclick = () => seek(time);
    const same = part ? `Both begin with the same ${part === 1 ? "action" : `${part} actions`} (cost ${show(one.ledger.spent[part])}). Then` : "They differ from the first action:";
    words.replaceChildren(`${same} ${does(one)}, and ${does(two)}. `, go);
    mark.style.left = `${(100 * time) / (duration || 1)}%`;
  }

  function endOf({ times }) {
    return Math.max(0, ...times.flat());
  }

  function step(by) {
    const starts = panels.flatMap(({ plan }) => [...plan.times.map(([start]) => start), endOf(plan)]);
    const next = by > 0 ? Math.min(...starts.filter((time) => time > clock.time + 1e-3)) : Math.max(...starts.filter((time) => time < clock.time - 1e-3));
    clock.pause();
    if (Number.isFinite(next)) seek(next);
  }

  function update() {
    for (const panel of panels) panel.show(clock.time);
    byId("scrub").value = String(clock.time);
    byId("time").textContent = `${clock.time.toFixed(1)} s of ${clock.duration.toFixed(1)} s`;
    byId("play").textContent = clock.playing ? "Pause" : "Play";
  }

  for (const box of document.querySelectorAll(".scroll")) watchEdges(box);
  in3d.onchange = showPictures;
  byId("play").onclick = () => clock.toggle();
  byId("back").onclick = () => step(-1);
  byId("on").onclick = () => step(1);
  byId("scrub").oninput = (event) => seek(Number(event.target.value));
  byId("speed").onchange = (event) => { clock.rate = Number(event.target.value); };
  rows.forEach(([, take, compare], index) => {
    take.onclick = () => select(index, other);
    compare.onclick = () => select(chosen, other === index ? null : index);
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("input, select, button, a, summary, [tabindex='0']:not(canvas)")) return;
    const acts = { " ": () => clock.toggle(), ArrowRight: () => step(1), ArrowLeft: () => step(-1) }[event.key];
    if (!acts) return;
    acts();
    event.preventDefault();
  });

  clock.rate = Number(byId("speed").value); // some browsers keep it when the page is loaded again
  const known = (name) => (wanted.has(name) && plans[Number(wanted.get(name))] ? Number(wanted.get(name)) : null);
  select(known("plan") ?? 0, wanted.has("plan") ? known("with") : plans.length > 1 ? plans.length - 1 : null);
  if (data.wishes) new Wishes(byId("wishes"), data, wish);
  if (wanted.has("plan") || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
  if (panels.some((panel) => panel.video || panel.map)) clock.play();
  else Promise.all(scenes).then((seen) => seen.some(Boolean) && clock.play());
})();
