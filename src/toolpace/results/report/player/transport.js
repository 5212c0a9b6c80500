const press = (group, button) => { for (const other of group) other.setAttribute("aria-pressed", String(other === button)); };

// Buttons of the view in space.
function wireCamera(space) {
  const cameras = [...document.querySelectorAll("[data-camera]")];
  for (const button of cameras) button.addEventListener("click", () => { press(cameras, button); if (space) space.look(button.dataset.camera); });
  for (const button of document.querySelectorAll("[data-do=frame]")) button.addEventListener("click", () => { if (space) space.frame(); });
}

// Buttons and keys: of a playback, of the time line that shows it, and of the view in space where there is one.
function wireTransport(playback, timeline, space) {
  const get = (id) => document.getElementById(id), all = (name) => [...document.querySelectorAll(`[data-${name}]`)];
  const actions = {
    play: () => (playback.playing ? playback.pause() : playback.play()),
    back: () => playback.step(-1), next: () => playback.step(1), begin: () => playback.seek(0), end: () => playback.seek(playback.duration),
    all: () => timeline.view(0, timeline.whole), closer: () => timeline.zoom(0.5), farther: () => timeline.zoom(2),
    frame: () => space && space.frame(),
  };
  for (const button of all("do")) if (actions[button.dataset.do] && button.dataset.do !== "frame") button.addEventListener("click", actions[button.dataset.do]);
  wireCamera(space);
  for (const button of all("layer")) {
    button.hidden = button.hasAttribute("hidden") && !space?.workpiece?.layers[button.dataset.layer];
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(on));
      if (space) space.show(button.dataset.layer, on);
    });
  }
  for (const button of all("colour")) {
    button.addEventListener("click", () => {
      press(all("colour"), button);
      if (!space) return;
      space.player.colouring = button.dataset.colour;
      space.recolour();
      showKey(space.player, get("key"));
    });
  }
  for (const button of all("tab")) button.addEventListener("click", () => showTab(button.dataset.tab));
  get("rate").addEventListener("change", (event) => { playback.rate = Number(event.target.value); });
  const rates = [...get("rate").options].map((o) => Number(o.value));
  const faster = (by) => {
    const k = rates.indexOf(playback.rate) + by;
    if (k >= 0 && k < rates.length) { playback.rate = rates[k]; get("rate").value = String(rates[k]); }
  };
  wireClock(playback);
  const keys = { " ": actions.play, g: () => get("at").focus(), Home: actions.begin, End: actions.end, "+": () => faster(1), "-": () => faster(-1), f: actions.frame,
    ArrowLeft: actions.back, ArrowRight: actions.next, "[": actions.farther, "]": actions.closer, 0: actions.all };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA|SUMMARY)$/.test(event.target.tagName)) return;
    if (event.key === " " && event.target.tagName === "BUTTON") return;
    if (event.shiftKey && /^Arrow(Left|Right)$/.test(event.key)) playback.seek(playback.t + (event.key === "ArrowLeft" ? -1 : 1));
    else if (keys[event.key] || keys[event.key.toLowerCase()]) (keys[event.key] || keys[event.key.toLowerCase()])();
    else return;
    event.preventDefault();
  });
}

// The time that words name, which are a time (12.5, 12.5 s, 1:30, 1:02:30) or a line of the program (line 120); NaN for others.
function namedTime(words, playback) {
  const line = /^(?:line|l)\s*(\d+)$/i.exec(words), time = /^(?:(?:(\d+):)?(\d+):)?(\d+(?:[.,]\d*)?)\s*s?$/i.exec(words);
  if (line && playback.lineTime) return playback.lineTime(Number(line[1]));
  return time ? 3600 * Number(time[1] || 0) + 60 * Number(time[2] || 0) + Number(time[3].replace(",", ".")) : NaN;
}

// The clock takes a time or a line to go to.
function wireClock(playback) {
  const at = document.getElementById("at");
  const leave = () => { at.classList.remove("bad"); at.blur(); playback.seek(playback.t); };
  at.addEventListener("focus", () => { playback.pause(); at.select(); });
  at.addEventListener("blur", () => { at.classList.remove("bad"); playback.seek(playback.t); });
  at.addEventListener("keydown", (event) => {
    if (event.key === "Escape") leave();
    if (event.key !== "Enter") return;
    const t = namedTime(at.value.trim(), playback);
    at.classList.toggle("bad", !(t <= playback.duration));
    if (t <= playback.duration) { playback.seek(t); leave(); }
  });
}

// The clock, and whether it runs.
function showClock(playback, words) {
  const get = (id) => document.getElementById(id);
  if (document.activeElement !== get("at")) get("at").value = clock(playback.t);
  get("whole").textContent = ` / ${clock(playback.duration, 0.01)}`;
  get("readout").textContent = words.filter(Boolean).join(" · ");
  get("play").setAttribute("aria-label", playback.playing ? "Pause" : "Play");
  document.body.classList.toggle("playing", !!playback.playing);
}

function showTab(name) {
  for (const button of document.querySelectorAll("[data-tab]")) button.setAttribute("aria-pressed", String(button.dataset.tab === name));
  for (const panel of document.querySelectorAll("[data-panel]")) panel.hidden = panel.dataset.panel !== name;
}

// What the colours of the path mean.
function showKey(player, key) {
  if (!key) return;
  key.replaceChildren();
  const load = player.load();
  if (load || player.colouring === "speed") {
    const bar = document.createElement("i");
    bar.className = "ramp";
    bar.style.background = `linear-gradient(90deg, ${[0, 0.2, 0.4, 0.6, 0.8, 1].map(speedColour).join(", ")})`;
    key.append(cell("0", "end"), bar, cell(load ? `${figure(load.high)} ${load.unit}` : `${spaced(player.usual)} mm/min and more`, "end"));
    return;
  }
  for (const k of [...new Set(player.strip)].sort((a, b) => a - b)) {
    const entry = cell(k < 0 ? "no limit reached" : player.limits[k].name, "entry"), mark = document.createElement("i");
    mark.style.background = k < 0 ? player.look.neutral : player.limits[k].colour;
    entry.prepend(mark);
    key.append(entry);
  }
}

// Fills the list of a tab with rows, of which the first cell leads to its time; a tab without rows is hidden.
function fillList(name, rows, seek) {
  const body = document.querySelector(`[data-panel="${name}"] tbody`);
  document.querySelector(`[data-tab="${name}"]`).hidden = !rows.length;
  body.replaceChildren(...rows.map((row) => {
    const line = document.createElement("tr"), button = document.createElement("button");
    button.type = "button";
    button.textContent = row.cells[0];
    button.addEventListener("click", () => seek(row.t));
    row.cells.forEach((text, k) => {
      const place = document.createElement("td");
      if (k) place.textContent = text; else place.append(button);
      line.append(place);
    });
    return line;
  }));
}

// Runs the page; where that fails, says so in it.
function begin(start) {
  start().catch((error) => {
    const word = document.getElementById("no-player");
    word.textContent = `The motion cannot be played here (${error.message}); a browser of the last two years can.`;
    word.hidden = false;
    throw error;
  });
}
