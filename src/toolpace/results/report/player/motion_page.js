// Ties the parts of a page that plays one motion together, with window.toolpace for those who embed it.
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
  for (const [name, rows] of Object.entries(costTables(player))) fillList(name, rows, (t) => player.seek(t));

  player.watchers.push((t) => {
    if (space) space.pose(t);
    if (player.playing) timeline.follow(t);
    timeline.cursor();
    const line = player.lineAt(t);
    if (program) program.light(line);
    const speed = player.valueAt("tip speed", t);
    showClock(player, [line ? `line ${line}` : "", player.operations.length > 1 ? player.operationName(player.operationAt(t)) : "",
      Number.isNaN(speed) ? "" : `${spaced(speed)} mm/min`, player.limitAt(t)]);
    if (space) joints(player, t);
  });

  for (const { name } of space ? player.loads : []) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    button.dataset.colour = name;
    button.setAttribute("aria-pressed", "false");
    document.querySelector("[data-colour]").parentElement.append(button);
  }
  for (const button of document.querySelectorAll("[data-seek]")) {
    button.addEventListener("click", () => { player.seek(button.dataset.seek); document.querySelector(".player").scrollIntoView({ block: "start" }); });
  }
  wireTransport(player, timeline, space);
  watchTheme(() => {
    player.readLook();
    timeline.draw();
    if (space) space.recolour();
    showKey(player, get("key"));
  });
  window.toolpace = { seek: (t) => player.seek(t), play: () => player.play(), pause: () => player.pause(), state: () => ({ ...player.state(), stock: space?.workpiece?.stage ?? null }),
    onScreen: (point) => space && space.onScreen(point) };
  showKey(player, get("key"));
  const tab = document.querySelector("[data-tab]:not([hidden])");
  if (tab) showTab(tab.dataset.tab); else document.querySelector(".side").remove();
  player.seek(0);
  window.toolpaceReady = true;
}

// Joint positions beside the view.
function joints(player, t) {
  const q = player.motion.at(t), box = document.getElementById("joints");
  box.textContent = player.joints.map((j, k) => (player.motion.rotary[k] ? `${j.name} ${((q[k] * 180) / Math.PI).toFixed(3)}°` : `${j.name} ${q[k].toFixed(3)}`)).join("   ");
}

begin(start);
