// The curves of plans, over the path of the first or over time.
class ComparedTracks extends Tracks {
  constructor(comparison, element) {
    super(element, 1);
    this.comparison = comparison;
    this.over(comparison.matched.length ? "path" : "time");
  }

  over(axis) {
    const t = this.axis ? this.comparison.t : 0;
    this.axis = axis;
    this.whole = axis === "path" ? this.comparison.way.at(-1) : this.comparison.duration;
    this.from = 0;
    this.to = this.whole;
    this.layOut();
    return t;
  }

  get onPath() { return this.axis === "path"; }
  get look() { return this.comparison.first.look; }
  step(least) { return this.onPath ? decimal(least) : super.step(least); }
  label(place, step) { return this.onPath ? `${spaced(place)} mm` : super.label(place, step); }

  // When a plan is at a place of the axis; NaN where it never is.
  timeOf(plan, place) {
    const { comparison } = this;
    if (this.onPath) return between(comparison.along.get(plan), (place / this.whole) * (ALONG - 1));
    return place <= plan.duration ? place : NaN;
  }

  placeOf(plan, t) {
    const { comparison } = this;
    return this.onPath ? comparison.wayAt(comparison.timeOfFirst(plan, t)) : t;
  }

  cursors() {
    const { comparison } = this;
    if (!this.onPath) return [{ place: comparison.t, colour: this.look.accent }];
    return [comparison.first, ...comparison.matched].map((plan) => ({ place: this.placeOf(plan, comparison.t), colour: plan.colour }));
  }

  choose(place) { this.comparison.seek(this.timeOf(this.comparison.first, place)); }

  words(place) {
    const { first, matched } = this.comparison, words = [];
    for (const plan of this.onPath ? [first, ...matched] : this.comparison.plans) {
      const t = this.timeOf(plan, place);
      if (!Number.isNaN(t)) words.push(`${plan.name}: ${plan.placeAt(t)}`);
    }
    return [this.onPath ? `${place.toFixed(1)} mm` : `${place.toFixed(3)} s`, ...words].join("\n");
  }

  rows() {
    const { comparison } = this, { first, plans, matched } = comparison, shown = this.onPath ? [first, ...matched] : plans;
    const speeds = shown.map((plan) => this.speed(plan)).filter(Boolean), high = 1.06 * Math.max(...shown.map((plan) => plan.highest));
    const out = [{ kind: "overview", height: OVERVIEW, series: speeds[0], high: first.highest }];
    if (first.operations.length > 1) {
      const bars = first.bars.map((bar) => ({ begin: this.placeOf(first, bar.begin), end: this.placeOf(first, bar.end), colour: bar.operation, name: first.operationName(bar.operation) }));
      out.push({ kind: "bars", height: BAR, title: `Operations, ${first.name}`, bars });
    }
    if (matched.length) out.push(this.gainedRow());
    out.push({ kind: "curves", height: 1.6 * PANEL, title: "Speed of the tip, mm/min; thin: feed in the program", low: 0, high, named: true, marks: niceTicks(high, 4).map((v) => [v, spaced(v)]),
      series: [...speeds, ...shown.map((plan) => this.feed(plan)).filter(Boolean)] });
    for (const plan of shown) {
      const of = (place, found, none) => { const t = this.timeOf(plan, place); return Number.isNaN(t) ? none : found(t); };
      out.push({ kind: "strip", height: STRIP, title: `What limits, ${plan.name}`, colour: (place) => of(place, (t) => plan.limitColour(t), this.look.ground),
        tell: (place) => of(place, (t) => plan.limitAt(t), "ended") });
    }
    return out;
  }

  // A curve of the tip over the axis.
  curve(plan, number) {
    const channel = plan.channels[number];
    if (!channel || !this.onPath) return channel && { values: channel.values, length: plan.duration };
    const { values } = channel, scale = (values.length - 1) / plan.duration;
    return { values: this.comparison.along.get(plan).map((t) => values[Math.round(t * scale)]) };
  }

  speed(plan) {
    const curve = this.curve(plan, 0);
    return curve && { ...curve, name: plan.name, colour: () => plan.colour, tell: (v) => `${spaced(v)} mm/min` };
  }

  feed(plan) {
    const curve = this.curve(plan, 1);
    return curve && { ...curve, name: "", width: 0.7, colour: () => plan.colour, tell: (v) => `feed ${spaced(v)} mm/min` };
  }

  gainedRow() {
    const { comparison } = this, { first, matched } = comparison, all = [];
    for (const plan of matched) {
      const values = this.onPath ? comparison.along.get(plan).map((t, k) => comparison.along.get(first)[k] - t)
        : plan.places.map((t, k) => (k / (plan.places.length - 1)) * first.duration - t);
      all.push({ values, length: this.onPath ? this.whole : first.duration, name: plan.name, width: 1.6, colour: () => plan.colour, tell: gainWords });
    }
    let low = 0, high = 0;
    for (const { values } of all) for (const v of values) { if (v < low) low = v; if (v > high) high = v; }
    const room = 0.08 * Math.max(high - low, 1e-3), step = decimal((high - low || 1e-3) / 4), marks = [];
    for (let k = Math.ceil(low / step); k * step <= high + 1e-12; k++) marks.push([k * step, `${k > 0 ? "+" : k < 0 ? "−" : ""}${figure(Math.abs(k * step))}`]);
    return { kind: "curves", height: 1.6 * PANEL, title: `Time gained on ${first.name}, s: rises where it is faster`, low: low - room, high: high + room, marks, series: all, named: true };
  }
}

function gainWords(v) { return Math.abs(v) < 5e-4 ? "level" : `${Math.abs(v).toFixed(3)} s ${v > 0 ? "ahead" : "behind"}`; }
