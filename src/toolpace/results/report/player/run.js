// A followed run: curves over time in panels, and the path in the plane in which it is widest, with dots on it.
const STRONG = ["#14a37f", "#d0455b", "#7a5bd0", "#c98a1b", "#2f6fed"];  // by name of an error, or by joint

class RunTracks extends Tracks {
  // whole: of the axis [s]; panels: of { title, series: [{ name, values, colour, area, unit }], high, bounds, low, named }
  constructor(element, whole, panels) {
    super(element, whole);
    this.panels = panels;
    this.at = 0;
    this.readLook();
  }

  readLook() { this.look = currentLook(); }
  cursors() { return [{ place: this.at, colour: this.look.accent }]; }
  choose(t) { this.seek(t); }
  words(t) { return `${t.toFixed(3)} s`; }

  rows() {
    const [first] = this.panels, rows = this.panels.map((panel) => this.row(panel));
    return [{ kind: "overview", height: OVERVIEW, series: { values: first.series[0].values }, high: rows[0].high }, ...rows];
  }

  row({ title, series, high, low = 0, bounds, named }) {
    const top = high || 1.06 * Math.max(1e-9, ...series.map((each) => largest(each.values)));
    const marks = niceTicks(top, 3).map((v) => [v, figure(v)]);
    return { kind: "curves", height: 1.2 * PANEL, title, low, high: top, marks: low < 0 ? [...niceTicks(-low, 3).slice(1).map((v) => [-v, figure(-v)]), ...marks] : marks, bounds, named,
      series: series.map((each) => ({ ...each, tell: (v) => `${figure(v)} ${each.unit}` })) };
  }
}

// Shares of the limits, a panel a kind: of path and correction together, of each.
function limitPanels(used) {
  return Object.entries(used).map(([kind, [path, own, both]], k) => ({
    title: `${kind[0].toUpperCase()}${kind.slice(1)}, % of the limit`, high: 112, bounds: [100], named: k === 0,
    series: [{ name: "both", values: both, width: 1, unit: "%", colour: (look) => look.soft }, { name: "path", values: path, width: 1, unit: "%", colour: (look) => look.accent },
      { name: "correction", values: own, width: 1, unit: "%", area: true, colour: (look) => look.second }],
  }));
}

class Plane {
  // ways: of { name, x, y, colour(look), width } in mm
  constructor(element, ways) {
    Object.assign(this, { element, ways, dots: [] });
    this.canvas = element.querySelector("canvas");
    new ResizeObserver(() => this.draw()).observe(element);
  }

  draw() {
    const look = currentLook(), { clientWidth: w, clientHeight: h } = this.element, scale = Math.min(window.devicePixelRatio || 1, 2);
    if (!w || !h) return;
    [this.canvas.width, this.canvas.height] = [Math.round(w * scale), Math.round(h * scale)];
    const ink = this.canvas.getContext("2d");
    ink.setTransform(scale, 0, 0, scale, 0, 0);
    ink.font = `11.5px ${look.font}`;
    const range = (values) => values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    const [x0, x1] = range(this.ways.flatMap((way) => way.x)), [y0, y1] = range(this.ways.flatMap((way) => way.y));
    const by = Math.min((w - 60) / Math.max(x1 - x0, 1e-6), (h - 60) / Math.max(y1 - y0, 1e-6));
    const at = (x, y) => [0.5 * w + by * (x - 0.5 * (x0 + x1)), 0.5 * h - by * (y - 0.5 * (y0 + y1))];
    for (const way of this.ways) {
      ink.strokeStyle = way.colour(look);
      ink.lineWidth = way.width;
      ink.beginPath();
      way.x.forEach((x, k) => ink.lineTo(...at(x, way.y[k])));
      ink.stroke();
    }
    for (const { x, y, colour } of this.dots) {
      ink.beginPath();
      ink.arc(...at(x, y), 6, 0, 2 * Math.PI);
      ink.fillStyle = colour;
      ink.strokeStyle = look.ground;
      ink.lineWidth = 1.5;
      ink.fill();
      ink.stroke();
    }
    // how long a round length is
    const long = decimal(80 / by);
    ink.strokeStyle = ink.fillStyle = look.soft;
    ink.beginPath();
    ink.moveTo(16, h - 16);
    ink.lineTo(16 + by * long, h - 16);
    ink.stroke();
    ink.fillText(`${figure(long)} mm`, 16, h - 22);
  }
}
