// Shows a follower while it runs: curves of the last half minute, joints, and where the tip is on its path.
class LiveTracks extends RunTracks {
  cursors() { return [{ place: this.whole, colour: this.look.accent }]; }
  choose() {}
  words(place) { return `${(this.whole - place).toFixed(1)} s ago`; }
  label(place) { return place > this.whole - 1e-6 ? "now" : `−${figure(this.whole - place)} s`; }
}

// The tip on its path, in the plane in which that is widest.
function inPlane({ way: [x, y], duration }) {
  const plane = new Plane(document.getElementById("plane"), [{ name: "path", x, y, colour: (look) => look.soft, width: 2 }]);
  const pose = ({ path_time: t }) => {
    const k = Math.min(Math.max(Math.round((t / duration) * (x.length - 1)), 0), x.length - 1);
    plane.dots = [{ x: x[k], y: y[k], colour: STRONG[0] }];
    plane.draw();
  };
  return { pose, repaint: () => plane.draw(), tip: () => null };
}

// The machine as its joints are; null where this browser shows no 3-D graphics.
async function inSpace(data) {
  const get = (id) => document.getElementById(id), player = new Player(data.motion, await Arrays.of(data.arrays)), { rotary } = player.motion;
  get("space-panel").hidden = false;
  let space;
  try { space = new Space(player, get("space")); } catch { get("space-panel").hidden = true; return null; }
  get("plane").remove();
  wireCamera(space);
  showKey(player, get("key"));
  const pose = ({ path_time: t, q }) => { player.t = t; space.pose(t, q.map((v, j) => (rotary[j] ? (v * Math.PI) / 180 : v))); };
  pose({ path_time: 0, q: player.motion.at(0).map((v, j) => (rotary[j] ? (v * 180) / Math.PI : v)) });
  return { pose, repaint: () => space.recolour(), tip: () => player.motion.machine.tool(space.posed, player.motion.length(player.t)).tip };
}

async function start() {
  const get = (id) => document.getElementById(id), data = JSON.parse(get("data").textContent), { kept, event: step } = data;
  const fresh = () => new Float64Array(kept).fill(NaN), used = Object.fromEntries(data.kinds.map((kind) => [kind, [fresh(), fresh(), fresh()]]));
  const corrections = data.units.map(() => fresh()), pace = fresh();
  const own = { title: "Correction of each joint, µm or 0.001°", named: true, high: 1, low: -1,
    series: corrections.map((values, j) => ({ name: data.joints[j], values, unit: data.units[j] === "mm" ? "µm" : "0.001°", colour: () => STRONG[j % STRONG.length] })) };
  const panels = [own, ...limitPanels(used), { title: "Pace, share of the plan's speed", high: 1.3, series: [{ name: "pace", values: pace, unit: "", colour: (look) => look.ink }] }];
  const tracks = new LiveTracks(get("timeline"), kept * step, panels);
  tracks.layOut();
  const shown = (data.motion && await inSpace(data)) || inPlane(data);
  watchTheme(() => { tracks.readLook(); tracks.draw(); shown.repaint(); });

  let last = null, waiting = false;
  const push = (values, value) => { values.copyWithin(0, 1); values[kept - 1] = value; };
  const take = (now) => {
    // what was dropped on the way is a gap
    const missed = last ? Math.min(Math.round((now.t - last.t) / step) - 1, kept) : 0;
    for (let k = 0; k < missed; k++) for (const values of [...corrections, pace, ...Object.values(used).flat()]) push(values, NaN);
    now.correction.forEach((v, j) => push(corrections[j], 1e3 * v));
    push(pace, now.pace);
    for (const kind of data.kinds) now.used[kind].forEach((v, k) => push(used[kind][k], v));
    last = now;
    if (!waiting) { waiting = true; requestAnimationFrame(show); }
  };
  const show = () => {
    waiting = false;
    const now = last, words = Object.entries(data.status).filter(([bit]) => now.status & Number(bit)).map(([, text]) => text);
    const [kind, most] = data.kinds.map((each) => [each, now.used[each][2]]).sort((a, b) => b[1] - a[1])[0];
    get("path-time").textContent = clock(now.path_time, 0.01);
    get("progress").value = now.path_time / data.duration;
    get("pace").textContent = now.pace.toFixed(3);
    get("deflection").textContent = now.deflection[0] === null ? "-" : `${Math.hypot(...now.deflection).toFixed(1)} µm`;
    get("most").textContent = `${most.toFixed(1)} %`;
    get("most-of").textContent = `of ${kind}, now`;
    get("status").textContent = words.join(", ") || "all is well";
    now.q.forEach((v, j) => { get(`q-${j}`).textContent = v.toFixed(4); get(`correction-${j}`).textContent = now.correction[j].toFixed(5); });
    shown.pose(now);
    const reach = Math.max(1, ...corrections.map((values) => largest(values.map(Math.abs))));
    Object.assign(own, { high: 1.1 * reach, low: -1.1 * reach });
    tracks.shown.splice(1, 1, Object.assign(tracks.row(own), { y: tracks.shown[1].y }));
    tracks.draw();
  };
  const badge = (text, kind) => { get("badge").textContent = text; get("badge").className = `badge ${kind}`; };
  const source = new EventSource("events");
  source.onmessage = (message) => { badge("live", "good"); take(JSON.parse(message.data)); };
  source.addEventListener("end", () => { source.close(); badge("ended", "quiet"); });
  source.onerror = () => { if (last) badge("no connection", "bad"); };
  window.toolpace = { state: () => last, tip: () => shown.tip() };
  window.toolpaceReady = true;
}

begin(start);
