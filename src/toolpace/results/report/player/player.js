// A motion and its program: what is told of each time.
class Player extends Playback {
  constructor(data, arrays) {
    super(data.duration);
    this.motion = data.keyframes ? new Motion(data, arrays) : null;
    this.joints = data.joints;
    this.channels = data.channels.map((c) => ({ ...c, values: arrays.numbers(c.data) }));
    this.scaleSpeeds();
    this.limits = data.limits.map((name, k) => ({ name, colour: data.colours[k] }));
    this.strip = arrays.whole(data.strip);
    this.operations = data.operations;
    this.passages = { t: arrays.numbers(data.passages.t).map((t) => Math.min(t, data.duration)), line: arrays.whole(data.passages.line),
      operation: arrays.whole(data.passages.operation), kind: arrays.whole(data.passages.kind) };
    this.text = data.program ? new TextDecoder().decode(arrays.bytes(data.program)).split("\n") : null;
    this.workpiece = data.workpiece || null;
    this.arrays = arrays;
    this.panels = data.panels || [];
    this.tracks = (data.tracks || []).map((c) => ({ ...c, values: arrays.numbers(c.data) }));
    this.states = data.states ? { names: data.states.names, values: arrays.whole(data.states.data) } : null;
    this.loads = (data.loads || []).map(({ name, track }) => ({ ...this.tracks[track], name }));
    for (const load of this.loads) load.high = this.loads.reduce((most, each) => each.values.reduce((a, b) => (b > a ? b : a), most), 1e-9);
    this.findings = data.findings || [];
    this.colouring = "speed";
    this.account();
    this.readLook();
  }

  // The time of each line and each operation, and the stretches of operations.
  account() {
    const { t, line, operation } = this.passages;
    this.lineTimes = new Map();
    this.lineBegins = new Map();
    this.operationTimes = new Map();
    this.bars = [];
    for (let k = 0; k < t.length; k++) {
      const end = k + 1 < t.length ? t[k + 1] : this.duration, time = end - t[k];
      this.lineTimes.set(line[k], (this.lineTimes.get(line[k]) || 0) + time);
      if (!k || line[k] !== line[k - 1]) {
        if (!this.lineBegins.has(line[k])) this.lineBegins.set(line[k], []);
        this.lineBegins.get(line[k]).push(t[k]);
      }
      const of = this.operationTimes.get(operation[k]) || { time: 0, begin: t[k] };
      of.time += time;
      this.operationTimes.set(operation[k], of);
      const bar = this.bars.at(-1);
      if (bar && bar.operation === operation[k]) bar.end = end;
      else this.bars.push({ operation: operation[k], begin: t[k], end });
    }
  }

  // The fastest that is passed at feed, for the curves; and what nearly all of it stays below, for the colours.
  scaleSpeeds() {
    const [speed, cap] = this.channels.filter((c) => c.panel === "feed").map((c) => c.values);
    this.highest = this.usual = 1;
    if (!speed) return;
    const cutting = cap ? speed.filter((v, i) => !Number.isNaN(cap[i])) : speed, sorted = (cutting.length ? cutting : speed).slice().sort();
    this.highest = Math.max(sorted.at(-1), 1e-6);
    this.usual = Math.min(1.05 * Math.max(sorted[Math.floor(0.97 * (sorted.length - 1))], 1e-6), this.highest);
  }

  // At the moment at which one ends the next is passed.
  passageAt(t) { return lastAt(this.passages.t, t + 1e-9); }
  lineAt(t) { return this.passages.line[this.passageAt(t)]; }
  // The next time at which a line is passed, or the first; NaN where it never is.
  lineTime(line) {
    const begins = this.lineBegins.get(line) || [];
    return begins.find((b) => b > this.t + 1e-9) ?? begins[0] ?? NaN;
  }
  placeAt(t) { const line = this.lineAt(t); return `${t.toFixed(3)} s${line ? `, line ${line}` : ""}`; }
  operationAt(t) { return this.passages.operation[this.passageAt(t)]; }
  kindAt(t) { return this.passages.kind[this.passageAt(t)]; }
  stripAt(t) { return this.strip[Math.min(Math.floor((t / this.duration) * this.strip.length), this.strip.length - 1)]; }
  // What the tool does at a time: the number of a state, -1 at rest; and in words.
  stateNumber(t) { const { values } = this.states; return values[Math.min(Math.floor((t / this.duration) * values.length), values.length - 1)]; }
  stateAt(t) { return this.states.names[this.stateNumber(t)] || "at rest"; }
  limitAt(t) { const k = this.stripAt(t); return k < 0 ? "no limit reached" : this.limits[k].name; }
  limitColour(t) { const k = this.stripAt(t); return k < 0 ? this.look.neutral : this.limits[k].colour; }
  // The colour of the path at a time at which the tip is so fast [mm/min].
  pathColour(t, speed) {
    const load = this.load();
    if (load) return speedColour(this.loadShare(load, t));
    return this.colouring === "limits" ? this.limitColour(t) : speedColour(Math.min(speed / this.usual, 1));
  }

  // The load by which the path is coloured, if it is by one; and its share of the largest at a time.
  // How fast the tip is at a time, and the feed where it is slower than that; and what limits it.
  paceAt(t) {
    const speed = this.valueAt("tip speed", t), feed = this.valueAt("feed in the program", t);
    if (Number.isNaN(speed)) return "";
    return speed < 0.95 * feed ? `${spaced(speed)} of ${spaced(feed)} mm/min` : `${spaced(speed)} mm/min`;
  }

  load() { return this.loads.find((each) => each.name === this.colouring) || null; }
  loadShare({ values, high }, t) { return Math.min(values[Math.min(Math.floor((t / this.duration) * values.length), values.length - 1)] / high, 1); }
  operationName(k) { const each = this.operations[k]; return each ? each.name || (each.tool ? `tool ${each.tool}` : `operation ${k + 1}`) : "-"; }

  valueAt(name, t) {
    const channel = this.channels.find((c) => c.panel === "feed" && c.name === name);
    return channel ? channel.values[Math.round((t / this.duration) * (channel.values.length - 1))] : NaN;
  }

  // Stretches that are passed slower than the program asks for, by the time that costs, each with what holds it back.
  slowPlaces() {
    const feed = this.channels.filter((c) => c.panel === "feed");
    if (feed.length < 2) return [];
    const [speed, cap] = feed.map((c) => c.values), n = speed.length, step = this.duration / Math.max(n - 1, 1), out = [];
    let now = null;
    const close = () => {
      if (!now) return;
      const [limit] = [...now.limits].sort((a, b) => b[1] - a[1])[0] || [-1];
      out.push({ ...now, limit: limit < 0 ? "" : this.limits[limit].name });
      now = null;
    };
    for (let i = 0; i < n; i++) {
      const share = cap[i] > 0 ? speed[i] / cap[i] : NaN;
      if (!(share < 0.95)) { close(); continue; }
      now = now || { lost: 0, share: 2, t: 0, limits: new Map() };
      now.lost += step * (1 - share);
      const k = this.stripAt(i * step);
      if (k > 0) now.limits.set(k, (now.limits.get(k) || 0) + 1);
      if (share < now.share) { now.share = share; now.t = i * step; }
    }
    close();
    return out.sort((a, b) => b.lost - a.lost);
  }

  readLook() { this.look = { ...currentLook(), joints: this.joints.map((j) => j.colour) }; }

  // To the beginning of the block that is passed, the one before or the next.
  step(by) {
    const { t } = this.passages;
    let k = this.passageAt(this.t + 1e-7);
    if (by > 0) { this.seek(k + 1 < t.length ? t[k + 1] : this.duration); return; }
    // several begin at the same moment where blocks are very short
    while (k > 0 && t[k] >= this.t - 1e-6) k--;
    this.seek(t[k]);
  }

  state() {
    const q = this.motion && this.motion.at(this.t).map((v, j) => (this.motion.rotary[j] ? (v * 180) / Math.PI : v));
    const tool = this.motion && this.motion.machine ? this.motion.tool(this.t) : null;
    return { t: this.t, line: this.lineAt(this.t), operation: this.operationName(this.operationAt(this.t)), playing: !!this.playing,
      q, tip: tool && tool.tip, axis: tool && tool.axis };
  }
}
