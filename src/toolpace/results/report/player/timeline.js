// The time line: operations, what limits, and curves over time; zoomed by wheel, dragged, clicked.
const PANEL = 84, OVERVIEW = 26, BAR = 18, STRIP = 14, GAP = 22, LEFT = 52, RIGHT = 10;

class Timeline {
  constructor(player, element) {
    this.player = player;
    this.element = element;
    this.canvas = element.querySelector("canvas.curves");
    this.overlay = element.querySelector("canvas.cursor");
    this.hint = element.querySelector(".hover");
    this.from = 0;
    this.to = player.duration;
    this.hidden = new Set();
    this.layOut();
    this.listen();
  }

  layOut() {
    const { player } = this;
    this.rows = [{ kind: "overview", height: OVERVIEW, title: "" }];
    if (player.operations.length > 1) this.rows.push({ kind: "operations", height: BAR, title: "Operations" });
    this.rows.push({ kind: "strip", height: STRIP, title: "What limits" });
    if (player.states) this.rows.push({ kind: "states", height: STRIP, title: "Air or material" });
    for (const [panel, title] of PANELS) {
      const channels = player.channels.filter((c) => c.panel === panel);
      if (channels.length && !this.hidden.has(panel)) this.rows.push({ kind: "curves", height: PANEL, panel, title, channels });
      if (panel === "feed") for (const each of player.panels) this.rows.push(trackRow(player, each));
    }
    let y = 6;
    for (const row of this.rows) { y += row.title ? GAP : 0; row.y = y; y += row.height; }
    this.height = y + 26;
    this.element.style.height = `${this.height}px`;
    this.resize();
  }

  resize() {
    this.width = this.element.clientWidth;
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    for (const canvas of [this.canvas, this.overlay]) {
      canvas.width = Math.round(this.width * scale);
      canvas.height = Math.round(this.height * scale);
      canvas.style.width = `${this.width}px`;
      canvas.style.height = `${this.height}px`;
      canvas.getContext("2d").setTransform(scale, 0, 0, scale, 0, 0);
    }
    this.draw();
  }

  get span() { return this.width - LEFT - RIGHT; }
  x(t) { return LEFT + ((t - this.from) / (this.to - this.from)) * this.span; }
  time(x) { return this.from + ((x - LEFT) / this.span) * (this.to - this.from); }

  view(from, to) {
    const whole = this.player.duration, width = Math.min(Math.max(to - from, Math.min(2e-3, whole)), whole);
    const begin = Math.min(Math.max(0.5 * (from + to - width), 0), whole - width);
    if (begin === this.from && begin + width === this.to) return;
    [this.from, this.to] = [begin, begin + width];
    this.draw();
  }

  // Keeps the cursor in sight while it plays.
  follow(t) {
    const width = this.to - this.from;
    if (t < this.from || t > this.to) this.view(t - 0.1 * width, t + 0.9 * width);
  }

  draw() {
    const ink = this.canvas.getContext("2d"), look = this.player.look;
    ink.clearRect(0, 0, this.width, this.height);
    ink.font = `11.5px ${look.font}`;
    for (const row of this.rows) {
      if (row.title) {
        ink.fillStyle = look.ink;
        ink.textAlign = "left";
        ink.fillText(row.title, LEFT, row.y - 6);
      }
      this[row.kind](ink, row, look);
    }
    this.ticks(ink, look);
    this.cursor();
  }

  overview(ink, row, look) {
    const speed = this.player.channels.find((c) => c.panel === "feed");
    ink.fillStyle = look.ground;
    ink.fillRect(LEFT, row.y, this.span, row.height);
    if (speed) this.area(ink, speed, 0, this.player.duration, row, 0, this.player.highest, look.good);
    const whole = this.player.duration, a = LEFT + (this.from / whole) * this.span, b = LEFT + (this.to / whole) * this.span;
    ink.fillStyle = look.veil;
    ink.fillRect(LEFT, row.y, a - LEFT, row.height);
    ink.fillRect(b, row.y, LEFT + this.span - b, row.height);
    ink.strokeStyle = look.accent;
    ink.lineWidth = 1.5;
    ink.strokeRect(a + 0.75, row.y + 0.75, Math.max(b - a - 1.5, 2), row.height - 1.5);
  }

  operations(ink, row, look) {
    const { bars } = this.player;
    ink.save();
    ink.beginPath();
    ink.rect(LEFT, row.y, this.span, row.height);
    ink.clip();
    ink.textAlign = "left";
    for (const bar of bars) {
      if (bar.end < this.from || bar.begin > this.to) continue;
      const a = this.x(bar.begin), b = this.x(bar.end);
      ink.fillStyle = look.bars[bar.operation % look.bars.length];
      ink.fillRect(a, row.y, Math.max(b - a - 0.6, 0.6), row.height);
      const name = this.player.operationName(bar.operation);
      if (b - a > 34) {
        ink.fillStyle = look.onBar;
        ink.save();
        ink.beginPath();
        ink.rect(Math.max(a, LEFT), row.y, b - Math.max(a, LEFT) - 3, row.height);
        ink.clip();
        ink.fillText(name, Math.max(a, LEFT) + 5, row.y + 13);
        ink.restore();
      }
    }
    ink.restore();
  }

  strip(ink, row, look) {
    const { strip, limits } = this.player, n = strip.length, whole = this.player.duration;
    for (let px = 0; px < this.span; px++) {
      const t = this.time(LEFT + px + 0.5), k = strip[Math.min(Math.floor((t / whole) * n), n - 1)];
      ink.fillStyle = k < 0 ? look.neutral : limits[k].colour;
      ink.fillRect(LEFT + px, row.y, 1.2, row.height);
    }
  }

  states(ink, row, look) {
    const { values, names } = this.player.states, n = values.length;
    for (let px = 0; px < this.span; px++) {
      const k = values[Math.min(Math.floor((this.time(LEFT + px + 0.5) / this.player.duration) * n), n - 1)];
      ink.fillStyle = k < 0 ? look.ground : STATE_COLOURS[k];
      ink.fillRect(LEFT + px, row.y, 1.2, row.height);
    }
    let x = LEFT + this.span;
    ink.textAlign = "right";
    for (const k of [...new Set(values)].filter((v) => v >= 0).sort((a, b) => b - a)) {
      ink.fillStyle = look.soft;
      ink.fillText(names[k], x, row.y - 6);
      x -= ink.measureText(names[k]).width + 15;
      ink.fillStyle = STATE_COLOURS[k];
      ink.fillRect(x, row.y - 15, 10, 10);
      x -= 10;
    }
  }

  // Curves in a unit of their own, from zero to their largest.
  tracks(ink, row, look) {
    const y = (v) => row.y + row.height * (1 - v / row.high);
    this.grid(ink, row, look, niceTicks(row.high, 3).map((mark) => [y(mark), figure(mark)]));
    ink.save();
    ink.beginPath();
    ink.rect(LEFT, row.y, this.span, row.height);
    ink.clip();
    row.channels.forEach((channel, k) => {
      const colour = trackColour(look, row, k);
      if (row.channels.length === 1) this.area(ink, channel, this.from, this.to, row, 0, row.high, colour);
      this.line(ink, channel, y, colour, 1.3);
    });
    ink.restore();
    this.names(ink, row, look);
  }

  // The ground of a panel, with marks: where each is, and what it says.
  grid(ink, row, look, marks) {
    ink.fillStyle = look.ground;
    ink.fillRect(LEFT, row.y, this.span, row.height);
    ink.strokeStyle = look.line;
    ink.lineWidth = 1;
    ink.fillStyle = look.soft;
    ink.textAlign = "right";
    for (const [y, text] of marks) {
      ink.beginPath();
      ink.moveTo(LEFT, y);
      ink.lineTo(LEFT + this.span, y);
      ink.stroke();
      ink.fillText(text, LEFT - 6, y + 4);
    }
  }

  curves(ink, row, look) {
    const feed = row.panel === "feed", off = row.panel === "deviation";
    const low = feed || off ? 0 : -1.12, high = feed ? 1.06 * this.player.highest : 1.12;
    const y = (v) => row.y + row.height * (1 - (v - low) / (high - low));
    const marks = feed ? niceTicks(high, 3) : off ? [0, 0.5, 1] : [-1, 0, 1];
    this.grid(ink, row, look, marks.map((mark) => [y(mark), feed ? spaced(mark) : `${Math.round(100 * mark)} %`]));
    if (!feed) {
      ink.strokeStyle = look.bad;
      ink.setLineDash([5, 4]);
      for (const mark of off ? [1] : [-1, 1]) {
        ink.beginPath();
        ink.moveTo(LEFT, y(mark));
        ink.lineTo(LEFT + this.span, y(mark));
        ink.stroke();
      }
      ink.setLineDash([]);
    }
    ink.save();
    ink.beginPath();
    ink.rect(LEFT, row.y, this.span, row.height);
    ink.clip();
    if (feed) this.area(ink, row.channels[0], this.from, this.to, row, low, high, look.good);
    row.channels.forEach((channel) => {
      const cap = feed && channel !== row.channels[0];
      const colour = feed ? (cap ? look.soft : look.good) : off ? (channel.joint === -1 ? look.ink : look.soft) : look.joints[channel.joint % look.joints.length];
      this.line(ink, channel, y, colour, cap ? 1 : 1.3);
    });
    ink.restore();
    this.names(ink, row, look);
  }

  names(ink, row, look) {
    const own = row.kind === "tracks";
    if (row.panel === "feed" || row.panel === "deviation" || (own && row.channels.length === 1)) return;
    let x = LEFT + this.span;
    ink.textAlign = "right";
    for (const channel of [...row.channels].reverse()) {
      ink.fillStyle = own ? trackColour(look, row, row.channels.indexOf(channel)) : look.joints[channel.joint % look.joints.length];
      ink.fillText(channel.name, x, row.y - 6);
      x -= ink.measureText(channel.name).width + 12;
    }
  }

  // Least and largest of a channel for each pixel, or its points where they are few.
  line(ink, channel, y, colour, width) {
    const v = channel.values, n = v.length, whole = this.player.duration;
    const first = Math.max(Math.floor((this.from / whole) * (n - 1)) - 1, 0);
    const last = Math.min(Math.ceil((this.to / whole) * (n - 1)) + 1, n - 1);
    ink.strokeStyle = colour;
    ink.lineWidth = width;
    ink.beginPath();
    let drawing = false;
    const put = (i) => {
      if (Number.isNaN(v[i])) { drawing = false; return; }
      const x = this.x((i / Math.max(n - 1, 1)) * whole);
      if (drawing) ink.lineTo(x, y(v[i])); else ink.moveTo(x, y(v[i]));
      drawing = true;
    };
    const many = last - first + 1, pixels = Math.max(Math.round(this.span), 1);
    if (many <= 2 * pixels) {
      for (let i = first; i <= last; i++) put(i);
    } else {
      for (let k = 0; k < pixels; k++) {
        const a = first + Math.floor((k * many) / pixels), b = first + Math.floor(((k + 1) * many) / pixels);
        let low = -1, high = -1;
        for (let i = a; i < b; i++) {
          if (Number.isNaN(v[i])) continue;
          if (low < 0 || v[i] < v[low]) low = i;
          if (high < 0 || v[i] > v[high]) high = i;
        }
        if (low < 0) { drawing = false; continue; }
        put(Math.min(low, high));
        if (low !== high) put(Math.max(low, high));
      }
    }
    ink.stroke();
  }

  area(ink, channel, from, to, row, low, high, colour) {
    const v = channel.values, n = v.length, whole = this.player.duration;
    ink.fillStyle = colour;
    ink.globalAlpha = 0.18;
    for (let px = 0; px < this.span; px++) {
      const a = Math.floor(((from + (px / this.span) * (to - from)) / whole) * (n - 1));
      const b = Math.max(Math.floor(((from + ((px + 1) / this.span) * (to - from)) / whole) * (n - 1)), a + 1);
      let top = 0;
      for (let i = a; i < b && i < n; i++) if (v[i] > top) top = v[i];
      const tall = Math.min((top - low) / (high - low), 1) * row.height;
      ink.fillRect(LEFT + px, row.y + row.height - tall, 1.05, tall);
    }
    ink.globalAlpha = 1;
  }

  ticks(ink, look) {
    ink.fillStyle = look.soft;
    ink.textAlign = "center";
    const step = niceStep((this.to - this.from) / Math.max(this.span / 90, 1));
    for (let k = Math.ceil(this.from / step); k * step <= this.to; k++) {
      ink.fillText(clock(k * step, step), this.x(k * step), this.height - 8);
    }
  }

  cursor() {
    const ink = this.overlay.getContext("2d"), { look, t } = this.player, x = this.x(t);
    ink.clearRect(0, 0, this.width, this.height);
    const overview = this.rows[0], small = LEFT + (t / this.player.duration) * this.span;
    ink.fillStyle = look.accent;
    ink.fillRect(small - 0.75, overview.y, 1.5, overview.height);
    if (x >= LEFT && x <= LEFT + this.span) {
      ink.fillRect(x - 0.75, overview.y + overview.height + 4, 1.5, this.height - overview.height - 34);
    }
    this.element.setAttribute("aria-valuenow", t.toFixed(3));
    this.element.setAttribute("aria-valuetext", this.player.placeAt(t));
  }

  listen() {
    const { overlay } = this;
    const at = (event) => {
      const box = overlay.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    let drag = null;
    overlay.addEventListener("pointerdown", (event) => {
      const [x, y] = at(event), overview = y < this.rows[0].y + OVERVIEW + 3;
      drag = { x, from: this.from, to: this.to, moved: false, overview };
      overlay.setPointerCapture(event.pointerId);
      if (overview) this.centre(x);
    });
    overlay.addEventListener("pointermove", (event) => {
      const [x, y] = at(event);
      if (!drag) { this.tell(x, y); return; }
      if (Math.abs(x - drag.x) > 3) drag.moved = true;
      if (drag.overview) this.centre(x);
      else if (drag.moved) {
        const shift = ((drag.x - x) / this.span) * (drag.to - drag.from);
        this.view(drag.from + shift, drag.to + shift);
      }
    });
    const release = (event) => {
      if (drag && !drag.moved && !drag.overview) this.player.seek(this.time(at(event)[0]));
      drag = null;
    };
    overlay.addEventListener("pointerup", release);
    overlay.addEventListener("pointercancel", () => { drag = null; });
    overlay.addEventListener("pointerleave", () => { this.hint.hidden = true; });
    overlay.addEventListener("dblclick", () => this.view(0, this.player.duration));
    overlay.addEventListener("wheel", (event) => {
      event.preventDefault();
      const t = this.time(at(event)[0]), by = Math.exp(0.0016 * (event.deltaY + event.deltaX));
      this.view(t - (t - this.from) * by, t + (this.to - t) * by);
    }, { passive: false });
    new ResizeObserver(() => { if (this.element.clientWidth !== this.width) this.resize(); }).observe(this.element);
  }

  centre(x) {
    const t = ((x - LEFT) / this.span) * this.player.duration, half = 0.5 * (this.to - this.from);
    if (this.to - this.from < this.player.duration) this.view(t - half, t + half);
    else this.player.seek(t);
  }

  zoom(by) {
    const t = Math.min(Math.max(this.player.t, this.from), this.to);
    this.view(t - (t - this.from) * by, t + (this.to - t) * by);
  }

  // What lies below the pointer, in words.
  tell(x, y) {
    const t = this.time(x), row = this.rows.find((r) => y >= r.y - 4 && y <= r.y + r.height + 4);
    if (!row || x < LEFT || x > LEFT + this.span || row.kind === "overview") { this.hint.hidden = true; return; }
    const lines = [this.player.placeAt(t)];
    if (row.kind === "operations") lines.push(this.player.operationName(this.player.operationAt(t)));
    if (row.kind === "strip") lines.push(this.player.limitAt(t));
    if (row.kind === "states") lines.push(this.player.stateAt(t));
    if (row.kind === "tracks") {
      for (const { name, unit, values } of row.channels) lines.push(`${name}: ${figure(values[Math.round((t / this.player.duration) * (values.length - 1))])} ${unit}`);
    }
    if (row.kind === "curves") {
      for (const channel of row.channels) {
        const v = channel.values[Math.round((t / this.player.duration) * (channel.values.length - 1))];
        if (Number.isNaN(v)) continue;
        lines.push(row.panel === "feed" ? `${channel.name}: ${spaced(v)} mm/min`
          : `${channel.name}: ${(100 * v).toFixed(1)} % (${figure(v * channel.peak)} ${channel.unit})`);
      }
    }
    this.hint.textContent = lines.join("\n");
    this.hint.hidden = false;
    this.hint.style.left = `${Math.min(x + 14, this.width - this.hint.offsetWidth - 4)}px`;
    this.hint.style.top = `${Math.min(y + 14, this.height - this.hint.offsetHeight - 4)}px`;
  }
}

const PANELS = [["feed", "Speed of the tip, mm/min"], ["deviation", "Off the program, share of the tolerance: tip (dark), tool axis (light)"],
  ["velocity", "Velocity, share of the limit"], ["acceleration", "Acceleration, share of the limit"], ["jerk", "Jerk, share of the limit"]];

const STATE_COLOURS = ["#c3ccd8", "#14a37f", "#e0b13c", "#7a9cf0"];  // in air, cutting, not sure, rapid

function trackRow(player, { name, title }) {
  const channels = player.tracks.filter((c) => c.panel === name);
  const high = 1.08 * Math.max(...channels.map((c) => c.values.reduce((most, v) => Math.max(most, v), 1e-9)));
  return { kind: "tracks", height: PANEL, panel: name, title, channels, high };
}

// By the place of the panel and of the curve in it.
function trackColour(look, row, k) { return ["#2f8f9d", "#8a5bd6", "#c9772b", "#b8405e"][(TRACK_TINTS[row.panel] || 0) + k]; }
const TRACK_TINTS = { removal: 0, engagement: 1, chip: 2, force: 3, deflection: 1 };

const figure = (v) => Number(v.toPrecision(4)).toString();
const spaced = (v) => Math.round(v).toString().replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");

function niceStep(least) {
  const unit = 10 ** Math.floor(Math.log10(Math.max(least, 1e-6)));
  for (const k of [1, 2, 5, 10]) if (k * unit >= least) return least > 10 ? sixtieth(least) : k * unit;
  return 10 * unit;
}

// From ten seconds on people count in sixtieths.
function sixtieth(least) {
  return [15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200].find((k) => k >= least) || 14400 * Math.ceil(least / 14400);
}

function niceTicks(top, count) {
  const step = decimal(top / count);
  return Array.from({ length: Math.floor(top / step) + 1 }, (_, k) => k * step);
}

function decimal(least) {
  const unit = 10 ** Math.floor(Math.log10(Math.max(least, 1e-9)));
  return [1, 2, 5, 10].map((k) => k * unit).find((k) => k >= least);
}

// A time as people write it: 12.5 s, 3:07, 1:02:30.
function clock(t, step = 0.001) {
  const digits = step >= 1 ? 0 : Math.min(Math.ceil(-Math.log10(step)), 4);
  t = Number(t.toFixed(digits));  // 59.9999 s are a minute
  if (t < 60 && step < 10) return `${t.toFixed(digits)} s`;
  const whole = Math.floor(t / 60), seconds = (t - 60 * whole).toFixed(digits).padStart(digits ? digits + 3 : 2, "0");
  const hours = Math.floor(whole / 60);
  return hours ? `${hours}:${String(whole % 60).padStart(2, "0")}:${seconds}` : `${whole}:${seconds}`;
}
