// The time line of a motion: operations, what limits, and curves over time.
const PANELS = [["feed", "Speed of the tip, mm/min"], ["deviation", "Off the program, share of the tolerance: tip (dark), tool axis (light)"],
  ["velocity", "Velocity, share of the limit"], ["acceleration", "Acceleration, share of the limit"], ["jerk", "Jerk, share of the limit"]];

const STATE_COLOURS = ["#c3ccd8", "#14a37f", "#e0b13c", "#7a9cf0"];  // in air, cutting, not sure, rapid
const TRACK_COLOURS = ["#2f8f9d", "#8a5bd6", "#c9772b", "#b8405e"];
const TRACK_TINTS = { removal: 0, engagement: 1, chip: 2, force: 3, deflection: 1 };  // the first colour of each panel

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
    if (player.states) out.push(this.states(player));
    if (player.findings.length) out.push(this.collisions(player));
    for (const [panel, title] of PANELS) {
      const channels = player.channels.filter((c) => c.panel === panel);
      if (channels.length) out.push({ kind: "curves", height: PANEL, title, ...this.scaled(panel), series: channels.map((c, k) => this.series(c, k)) });
      if (panel === "feed") out.push(...player.panels.map((each) => this.track(each)));
    }
    return out;
  }

  // What the tool does, by colours.
  states(player) {
    const key = [...new Set(player.states.values)].filter((k) => k >= 0).sort((a, b) => a - b).map((k) => [player.states.names[k], STATE_COLOURS[k]]);
    return { kind: "strip", height: STRIP, title: "Air or material", key, colour: (t) => STATE_COLOURS[player.stateNumber(t)] || this.look.ground, tell: (t) => player.stateAt(t) };
  }

  // Where the tool meets what it must not: three pixels wide at least.
  collisions({ findings }) {
    const near = (t) => findings.filter((each) => Math.abs(each.t - t) <= 0.5 * each.duration + (1.5 * (this.to - this.from)) / this.span);
    return { kind: "strip", height: STRIP, title: "Collisions", colour: (t) => (near(t).length ? this.look.bad : this.look.ground),
      tell: (t) => near(t).map((each) => each.text).join("\n") || "none" };
  }

  // Curves of the cut in a unit of their own, from zero to their largest.
  track({ name, title }) {
    const channels = this.player.tracks.filter((c) => c.panel === name), tint = TRACK_TINTS[name] || 0;
    const high = 1.08 * Math.max(...channels.map((c) => c.values.reduce((most, v) => (v > most ? v : most), 1e-9)));
    const series = channels.map((c, k) => ({ ...c, ...this.role(c, TRACK_COLOURS[tint + k]), area: channels.length === 1, tell: (v) => `${figure(v)} ${c.unit}` }));
    return { kind: "curves", height: PANEL, title, low: 0, high, marks: niceTicks(high, 3).map((v) => [v, figure(v)]), series, named: channels.length > 1 };
  }

  // How a curve before or after a change is drawn, or a limit; any other has a colour of its own.
  role({ role }, own) {
    if (role === "before") return { colour: (look) => look.soft, width: 1.1 };
    if (role === "limit") return { colour: (look) => look.bad, width: 1.1 };
    return { colour: (look) => (role === "after" ? look.accent : own), width: role === "after" ? 1.7 : 1.3 };
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
