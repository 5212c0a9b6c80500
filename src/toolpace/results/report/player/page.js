// Ties the parts of the page together: buttons, keys, and window.toolpace for those who embed it.
async function start() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const player = new Player(data, await Arrays.of(data.arrays));
  const get = (id) => document.getElementById(id);
  const timeline = new Timeline(player, get("timeline"));
  let space = null;
  if (player.motion && player.motion.machine) {
    try { space = new Space(player, get("space")); } catch (error) { get("space").classList.add("none"); get("no-space").hidden = false; }
  } else get("space-panel").remove();
  const program = player.text ? new Program(player, get("listing"), player.text) : null;
  if (!program) get("tab-program").hidden = true;
  tables(player);

  const clockOf = get("clock"), readout = get("readout"), playButton = get("play");
  player.watchers.push((t) => {
    if (space) space.pose(t);
    if (player.playing) timeline.follow(t);
    timeline.cursor();
    const line = player.lineAt(t);
    if (program) program.light(line);
    clockOf.textContent = `${clock(t)} / ${clock(player.duration, 0.01)}`;
    const speed = player.valueAt("tip speed", t), words = [line ? `line ${line}` : "", player.operations.length > 1 ? player.operationName(player.operationAt(t)) : "",
      Number.isNaN(speed) ? "" : `${spaced(speed)} mm/min`, player.limitAt(t)];
    readout.textContent = words.filter(Boolean).join(" · ");
    playButton.setAttribute("aria-label", player.playing ? "Pause" : "Play");
    document.body.classList.toggle("playing", !!player.playing);
    if (space) joints(player, t);
  });

  const colourKey = () => showKey(player, get("key"));
  const press = (group, button) => { for (const other of group) other.setAttribute("aria-pressed", String(other === button)); };
  const actions = {
    play: () => (player.playing ? player.pause() : player.play()),
    back: () => player.step(-1), next: () => player.step(1), begin: () => player.seek(0), end: () => player.seek(player.duration),
    all: () => timeline.view(0, player.duration), closer: () => timeline.zoom(0.5), farther: () => timeline.zoom(2),
    frame: () => space && space.frame(), theme: () => theme(player, timeline, space),
  };
  for (const button of document.querySelectorAll("[data-do]")) button.addEventListener("click", () => actions[button.dataset.do]());
  for (const button of document.querySelectorAll("[data-camera]")) {
    button.addEventListener("click", () => { press(document.querySelectorAll("[data-camera]"), button); if (space) space.look(button.dataset.camera); });
  }
  for (const button of document.querySelectorAll("[data-layer]")) {
    button.hidden = button.hasAttribute("hidden") && !space?.workpiece?.layers[button.dataset.layer];
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(on));
      if (space) space.show(button.dataset.layer, on);
    });
  }
  for (const button of document.querySelectorAll("[data-colour]")) {
    button.addEventListener("click", () => {
      press(document.querySelectorAll("[data-colour]"), button);
      player.colouring = button.dataset.colour;
      if (space) space.recolour();
      colourKey();
    });
  }
  for (const button of document.querySelectorAll("[data-tab]")) button.addEventListener("click", () => showTab(button.dataset.tab));
  get("rate").addEventListener("change", (event) => { player.rate = Number(event.target.value); });
  const rates = [...get("rate").options].map((o) => Number(o.value));
  const faster = (by) => {
    const k = rates.indexOf(player.rate) + by;
    if (k >= 0 && k < rates.length) { player.rate = rates[k]; get("rate").value = String(rates[k]); }
  };
  const keys = { " ": actions.play, Home: actions.begin, End: actions.end, "+": () => faster(1), "-": () => faster(-1), f: actions.frame,
    ArrowLeft: actions.back, ArrowRight: actions.next, "[": actions.farther, "]": actions.closer, 0: actions.all };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA|SUMMARY)$/.test(event.target.tagName)) return;
    if (event.key === " " && event.target.tagName === "BUTTON") return;
    if (event.shiftKey && /^Arrow(Left|Right)$/.test(event.key)) player.seek(player.t + (event.key === "ArrowLeft" ? -1 : 1));
    else if (keys[event.key] || keys[event.key.toLowerCase()]) (keys[event.key] || keys[event.key.toLowerCase()])();
    else return;
    event.preventDefault();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => repaint(player, timeline, space));
  // paper is light
  let shown;
  window.addEventListener("beforeprint", () => { shown = document.documentElement.dataset.theme; dress("light", player, timeline, space); });
  window.addEventListener("afterprint", () => dress(shown, player, timeline, space));
  window.toolpace = { seek: (t) => player.seek(t), play: () => player.play(), pause: () => player.pause(), state: () => ({ ...player.state(), stock: space?.workpiece?.stage ?? null }),
    onScreen: (point) => space && space.onScreen(point) };
  colourKey();
  const tab = document.querySelector("[data-tab]:not([hidden])");
  if (tab) showTab(tab.dataset.tab); else document.querySelector(".side").remove();
  player.seek(0);
  window.toolpaceReady = true;
}

function theme(player, timeline, space) {
  const root = document.documentElement, dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  dress(dark ? "light" : "dark", player, timeline, space);
}

// In the colours of a theme; of the system's without a name.
function dress(name, player, timeline, space) {
  if (name) document.documentElement.dataset.theme = name; else delete document.documentElement.dataset.theme;
  repaint(player, timeline, space);
}

function repaint(player, timeline, space) {
  player.readLook();
  timeline.draw();
  if (space) space.recolour();
  showKey(player, document.getElementById("key"));
}

function showTab(name) {
  for (const button of document.querySelectorAll("[data-tab]")) button.setAttribute("aria-pressed", String(button.dataset.tab === name));
  for (const panel of document.querySelectorAll("[data-panel]")) panel.hidden = panel.dataset.panel !== name;
}

// Joint positions beside the view.
function joints(player, t) {
  const q = player.motion.at(t), box = document.getElementById("joints");
  box.textContent = player.joints.map((j, k) => (player.motion.rotary[k] ? `${j.name} ${((q[k] * 180) / Math.PI).toFixed(3)}°` : `${j.name} ${q[k].toFixed(3)}`)).join("   ");
}

// What the colours of the path mean.
function showKey(player, key) {
  if (!key) return;
  key.replaceChildren();
  if (player.colouring === "speed") {
    const bar = document.createElement("i");
    bar.className = "ramp";
    bar.style.background = `linear-gradient(90deg, ${[0, 0.2, 0.4, 0.6, 0.8, 1].map(speedColour).join(", ")})`;
    key.append(cell("0", "end"), bar, cell(`${spaced(player.usual)} mm/min and more`, "end"));
    return;
  }
  for (const k of [...new Set(player.strip)].sort((a, b) => a - b)) {
    const entry = cell(k < 0 ? "no limit reached" : player.limits[k].name, "entry"), mark = document.createElement("i");
    mark.style.background = k < 0 ? player.look.neutral : player.limits[k].colour;
    entry.prepend(mark);
    key.append(entry);
  }
}

// Where the time goes.
function tables(player) {
  for (const [name, rows] of Object.entries(costTables(player))) {
    const body = document.querySelector(`[data-panel="${name}"] tbody`);
    if (!rows.length) { document.querySelector(`[data-tab="${name}"]`).hidden = true; continue; }
    body.append(...rows.map((row) => {
      const line = document.createElement("tr"), button = document.createElement("button");
      button.type = "button";
      button.textContent = row.cells[0];
      button.addEventListener("click", () => player.seek(row.t));
      row.cells.forEach((text, k) => {
        const place = document.createElement("td");
        if (k) place.textContent = text; else place.append(button);
        line.append(place);
      });
      return line;
    }));
  }
}

start().catch((error) => {
  const word = document.getElementById("no-player");
  word.textContent = `The motion cannot be played here (${error.message}); a browser of the last two years can.`;
  word.hidden = false;
  throw error;
});
