// Shows a follower while it runs: curves of the last half minute, joints, and where the tip is on its path.
class LiveTracks extends RunTracks {
  cursors() { return [{ place: this.whole, colour: this.look.accent }]; }
  choose() {}
  words(place) { return `${(this.whole - place).toFixed(1)} s ago`; }
  label(place) { return place > this.whole - 1e-6 ? "now" : `−${figure(this.whole - place)} s`; }
}

async function start() {
  const get = (id) => document.getElementById(id), data = JSON.parse(get("data").textContent), { kept, event: step } = data;
  const fresh = () => new Float64Array(kept).fill(NaN), used = Object.fromEntries(data.kinds.map((kind) => [kind, [fresh(), fresh(), fresh()]]));
  const corrections = data.units.map(() => fresh()), pace = fresh();
  const own = { title: "Correction of each joint, µm or 0.001°", named: true, high: 1, low: -1,
    series: corrections.map((values, j) => ({ name: `joint ${j}`, values, unit: data.units[j] === "mm" ? "µm" : "0.001°", colour: () => STRONG[j % STRONG.length] })) };
  const panels = [own, ...limitPanels(used), { title: "Pace, share of the plan's speed", high: 1.3, series: [{ name: "pace", values: pace, unit: "", colour: (look) => look.ink }] }];
  const tracks = new LiveTracks(get("timeline"), kept * step, panels);
  tracks.layOut();
  const plane = new Plane(get("plane"), [{ name: "path", x: data.way[0], y: data.way[1], colour: (look) => look.soft, width: 2 }]);
  watchTheme(() => { tracks.readLook(); tracks.draw(); plane.draw(); });

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
    const at = Math.round((now.path_time / data.duration) * (data.way[0].length - 1)), k = Math.min(Math.max(at, 0), data.way[0].length - 1);
    plane.dots = [{ x: data.way[0][k], y: data.way[1][k], colour: STRONG[0] }];
    plane.draw();
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
  window.toolpace = { state: () => last };
  window.toolpaceReady = true;
}

begin(start);
