// The time line of a motion: operations, what limits, and curves over time.
const PANELS = [["feed", "Speed of the tip, mm/min"], ["deviation", "Off the program, share of the tolerance: tip (dark), tool axis (light)"],
  ["velocity", "Velocity, share of the limit"], ["acceleration", "Acceleration, share of the limit"], ["jerk", "Jerk, share of the limit"]];
const STATE_COLOURS = ["#9aa7b8", "#14a37f", "#e0b13c", "#7a9cf0"];  // in air, cutting, not sure, rapid
const TRACK_COLOURS = ["#2f8f9d", "#8a5bd6", "#c9772b", "#b8405e"], TINTS = { engagement: 1, chip: 2, force: 3, deflection: 1 };

class Timeline extends Tracks {
  constructor(player, element) {
    super(element, player.duration);
    this.player = player;
    this.layOut();
  }

  get look() { return this.player.look; }
  cursors() { return [{ place: this.player.t, colour: this.look.accent }]; }
  choose(t) { this.player.seek(t); }
  words(t) { return this.player.placeAt(t); }

  rows() {
    const { player } = this;
    const out = [{ kind: "overview", height: OVERVIEW, series: player.channels.find((c) => c.panel === "feed"), high: player.highest }];
    if (player.operations.length > 1) {
      const bars = player.bars.map((bar) => ({ ...bar, colour: bar.operation, name: player.operationName(bar.operation) }));
      out.push({ kind: "bars", height: BAR, title: "Operations", bars, tell: (t) => player.operationName(player.operationAt(t)) });
    }
    out.push({ kind: "strip", height: STRIP, title: "What limits", colour: (t) => player.limitColour(t), tell: (t) => player.limitAt(t) });
    if (player.states) out.push(this.statesRow());
    for (const [panel, title] of PANELS) {
      const channels = player.channels.filter((c) => c.panel === panel);
      if (channels.length) out.push({ kind: "curves", height: PANEL, title, ...this.scaled(panel), series: channels.map((c, k) => this.series(c, k)) });
      if (panel === "feed") out.push(...player.panels.map((each) => this.trackRow(each)));
    }
    return out;
  }

  // Whether the tool is in air or in material.
  statesRow() {
    const { player } = this, colour = (k) => STATE_COLOURS[k] || this.look.ground;
    const there = [...new Set(player.states.values)].filter((k) => k >= 0).sort((a, b) => a - b);
    return { kind: "strip", height: STRIP, title: "Air or material", colour: (t) => colour(player.stateAt(t)), tell: (t) => player.stateName(player.stateAt(t)),
      named: true, series: there.map((k) => ({ name: player.stateName(k), colour: () => colour(k) })) };
  }

  // What the cut takes, in a unit of its own, from zero to its largest.
  trackRow({ name, title }) {
    const tracks = this.player.tracks.filter((c) => c.panel === name), first = TINTS[name] || 0;
    const high = 1.08 * tracks.reduce((most, c) => c.values.reduce((a, b) => Math.max(a, b), most), 1e-9);
    return { kind: "curves", height: PANEL, title, low: 0, high, marks: niceTicks(high, 3).map((v) => [v, figure(v)]), named: tracks.length > 1,
      series: tracks.map((c, k) => ({ ...c, colour: () => TRACK_COLOURS[(first + k) % TRACK_COLOURS.length], area: tracks.length === 1, tell: (v) => `${figure(v)} ${c.unit}` })) };
  }

  // The range of a panel, its marks and the bounds in it.
  scaled(panel) {
    const high = 1.06 * this.player.highest, share = (v) => [v, `${Math.round(100 * v)} %`];
    if (panel === "feed") return { low: 0, high, marks: niceTicks(high, 3).map((v) => [v, spaced(v)]) };
    if (panel === "deviation") return { low: 0, high: 1.12, marks: [0, 0.5, 1].map(share), bounds: [1] };
    return { low: -1.12, high: 1.12, marks: [-1, 0, 1].map(share), bounds: [-1, 1], named: true };
  }

  // How a channel is drawn, and how its values are told.
  series(channel, k) {
    if (channel.panel === "feed") {
      return { ...channel, colour: (look) => (k ? look.soft : look.good), width: k ? 1 : 1.3, area: !k, tell: (v) => `${spaced(v)} mm/min` };
    }
    const colour = channel.panel === "deviation" ? (look) => (channel.joint === -1 ? look.ink : look.soft)
      : (look) => look.joints[channel.joint % look.joints.length];
    return { ...channel, colour, tell: (v) => `${(100 * v).toFixed(1)} % (${figure(v * channel.peak)} ${channel.unit})` };
  }
}
