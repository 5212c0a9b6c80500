// Ties the parts of the page together, with window.toolpace for those who embed it.
async function start() {
  watchTheme(() => repaint());
  const get = (id) => document.getElementById(id), data = JSON.parse(get("data").textContent);
  let repaint = () => {};
  if (!data.plans.length) { get("played").remove(); window.toolpaceReady = true; return; }
  const comparison = new Comparison(data, await Arrays.of(data.arrays)), { first, plans } = comparison;
  let space = null, ghosts = [];
  try {
    space = new Space(first, get("space"));
    ghosts = plans.slice(1).map((plan) => new Ghost(space, plan));
    space.toolShape.material.color.set(first.colour);
  } catch (error) { get("space").classList.add("none"); get("no-space").hidden = false; }
  const tracks = new ComparedTracks(comparison, get("timeline"));
  const texts = new Texts(comparison);
  const chips = planChips(comparison, () => { texts.lists(); if (space) space.recolour(); key(); });

  comparison.watchers.push((t) => {
    for (const ghost of ghosts) ghost.pose();
    if (space) space.pose(first.t);
    if (comparison.playing) tracks.follow(tracks.cursors()[0].place);
    tracks.cursor();
    texts.light();
    chips();
    showClock(comparison, []);
  });

  const key = () => { if (first.colouring === "faster") fasterKey(comparison, get("key")); else showKey(first, get("key")); };
  wireTransport(comparison, tracks, space);
  for (const button of document.querySelectorAll("[data-colour]")) {
    button.addEventListener("click", key);
    button.setAttribute("aria-pressed", String(button.dataset.colour === first.colouring));
    if (button.dataset.colour === "faster") button.hidden = first.colouring !== "faster";
  }
  get("ghosts").hidden = !ghosts.length;
  get("ghosts").addEventListener("click", () => {
    const on = get("ghosts").getAttribute("aria-pressed") !== "true";
    get("ghosts").setAttribute("aria-pressed", String(on));
    for (const ghost of ghosts) ghost.show(on);
  });
  wireAxis(tracks);
  repaint = () => {
    for (const plan of plans) plan.readLook();
    tracks.draw();
    if (space) space.recolour();
    key();
  };
  window.toolpace = { seek: (t) => comparison.seek(t), play: () => comparison.play(), pause: () => comparison.pause(), state: () => comparison.state(),
    onScreen: (point) => space && space.onScreen(point) };
  key();
  const tab = document.querySelector("[data-tab]:not([hidden])");
  if (tab) showTab(tab.dataset.tab); else document.querySelector(".side").remove();
  comparison.seek(0);
  window.toolpaceReady = true;
}

// Over the path or over time.
function wireAxis(tracks) {
  const buttons = [...document.querySelectorAll("[data-axis]")];
  const choose = (axis) => {
    tracks.over(axis);
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset.axis === axis));
  };
  for (const button of buttons) button.addEventListener("click", () => choose(button.dataset.axis));
  if (!tracks.comparison.matched.length) { buttons[0].parentElement.hidden = true; return; }
  document.addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() !== "p" || event.ctrlKey || event.metaKey || event.altKey) return;
    choose(tracks.onPath ? "time" : "path");
  });
}

// What each plan does now; a click on the name of one makes the lists and the colours tell of it.
function planChips(comparison, chosen) {
  const { plans, first } = comparison, box = document.getElementById("plans");
  const chips = plans.map((plan) => {
    const chip = cell("", "plan"), mark = document.createElement("i"), name = document.createElement("button"), words = cell("", "words"), gain = document.createElement("b");
    mark.style.background = plan.colour;
    name.type = "button";
    name.textContent = plan.name;
    name.disabled = plan === first || plans.length < 3;
    name.addEventListener("click", () => {
      comparison.other = plan;
      for (const each of chips) each.name.setAttribute("aria-pressed", String(each.plan === plan));
      chosen();
    });
    name.setAttribute("aria-pressed", String(plans.length > 2 && plan === comparison.other));
    chip.append(mark, name, words, gain);
    box.append(chip);
    return { plan, name, words, gain };
  });
  return () => {
    for (const { plan, words, gain } of chips) {
      const line = plan.lineAt(plan.t), speed = plan.valueAt("tip speed", plan.t), gained = comparison.gained(plan, first.t);
      const ended = plan.t >= plan.duration && comparison.t > plan.duration;
      words.textContent = [ended ? "ended" : line ? `line ${line}` : "", Number.isNaN(speed) || ended ? "" : `${spaced(speed)} mm/min`].filter(Boolean).join(" · ");
      gain.hidden = plan === first || Number.isNaN(gained);
      gain.textContent = gainWords(gained);
      gain.className = gained > 5e-4 ? "gains" : gained < -5e-4 ? "loses" : "";
    }
  };
}

function fasterKey(comparison, key) {
  const { first, other } = comparison, bar = document.createElement("i");
  bar.className = "ramp";
  bar.style.background = `linear-gradient(90deg, ${first.colour}, ${ALIKE}, ${other.colour})`;
  key.replaceChildren(cell(`${first.name} faster`, "end"), bar, cell(`${other.name} faster`, "end"));
}

// The programs, with the lines that run lit in each, and the lists of what differs.
class Texts {
  constructor(comparison) {
    this.comparison = comparison;
    const get = (id) => document.getElementById(id), { first } = comparison;
    this.first = first.text ? new Program(first, get("listing"), first.text) : null;
    document.querySelector('[data-tab="program"]').hidden = !this.first;
    this.lists();
  }

  lists() {
    const { comparison } = this, { first, other } = comparison, tab = document.querySelector('[data-tab="other-program"]');
    const differs = !!other && !!other.text && other.text !== first.text;
    this.other = differs ? new Program(other, document.getElementById("other-listing"), other.text) : null;
    tab.hidden = !differs;
    if (differs) {
      tab.textContent = `Program, ${other.name}`;
      document.querySelector('[data-tab="program"]').textContent = `Program, ${first.name}`;
    }
    for (const [name, rows] of Object.entries(differences(comparison))) fillList(name, rows, (t) => comparison.seek(t));
  }

  light() {
    const { comparison } = this, { first, other } = comparison;
    if (this.first) this.first.light(first.lineAt(first.t), other && !this.other && other.text ? other.lineAt(other.t) : 0);
    if (this.other) this.other.light(other.lineAt(other.t));
  }
}

// Blocks and operations by how much the other gains or loses in them.
function differences(comparison) {
  const { first, other } = comparison, seconds = (v) => `${v < 0 ? "−" : "+"}${figure(Math.abs(v))} s`;
  if (!other) return { blocks: [], operations: [] };
  const blocks = other.text !== first.text || !first.text ? [] : [...first.lineTimes].filter(([line]) => line > 0)
    .map(([line, time]) => ({ line, time, gained: time - (other.lineTimes.get(line) || 0) })).sort((a, b) => Math.abs(b.gained) - Math.abs(a.gained)).slice(0, 100)
    .map((each) => ({ t: first.lineBegins.get(each.line)[0], cells: [`line ${each.line}`, (first.text[each.line - 1] || "").slice(0, WIDEST).trim(), `${figure(each.time)} s`, seconds(each.gained)] }));
  const alike = first.operations.length === other.operations.length && first.operations.every((each, k) => each.name === other.operations[k].name && each.tool === other.operations[k].tool);
  const operations = !alike ? [] : [...first.operationTimes].filter(([k]) => first.operations[k])
    .map(([k, each]) => ({ t: each.begin, k, time: each.time, gained: each.time - (other.operationTimes.get(k) || { time: 0 }).time })).sort((a, b) => Math.abs(b.gained) - Math.abs(a.gained))
    .map((each) => ({ t: each.t, cells: [first.operationName(each.k), first.operations[each.k].tool ? `tool ${first.operations[each.k].tool}` : "", `${figure(each.time)} s`, seconds(each.gained)] }));
  return { blocks, operations };
}

begin(start);
