// Rows of curves and bars over one axis: zoomed by wheel, dragged, clicked. Who draws with it tells the rows, the
// cursors and the words: Timeline over the time of a motion, others over what they compare.
const PANEL = 84, OVERVIEW = 26, BAR = 18, STRIP = 14, GAP = 22, LEFT = 52, RIGHT = 10;
const SHORTEST = 2e-3;  // of what is seen at once

class Tracks {
  // whole: length of the axis. Subclasses have rows(), cursors(), look, choose(place), words(place) and label(place, step).
  constructor(element, whole) {
    this.element = element;
    this.canvas = element.querySelector("canvas.curves");
    this.overlay = element.querySelector(".cursors");
    this.marks = [];
    this.hint = element.querySelector(".hover");
    this.whole = whole;
    this.from = 0;
    this.to = whole;
  }

  // Places the rows; for a subclass to call when it can tell them.
  layOut() {
    this.shown = this.rows();
    let y = 6;
    for (const row of this.shown) { y += row.title ? GAP : 0; row.y = y; y += row.height; }
    this.height = y + 26;
    this.element.style.height = `${this.height}px`;
    this.resize();
    if (!this.heard) this.listen();
    this.heard = true;
  }

  resize() {
    this.width = this.element.clientWidth;
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    const { canvas } = this;
    canvas.width = Math.round(this.width * scale);
    canvas.height = Math.round(this.height * scale);
    canvas.style.width = `${this.width}px`;
    canvas.style.height = `${this.height}px`;
    canvas.getContext("2d").setTransform(scale, 0, 0, scale, 0, 0);
    this.draw();
  }

  get span() { return this.width - LEFT - RIGHT; }
  x(place) { return LEFT + ((place - this.from) / (this.to - this.from)) * this.span; }
  place(x) { return this.from + ((x - LEFT) / this.span) * (this.to - this.from); }

  view(from, to) {
    const { whole } = this, width = Math.min(Math.max(to - from, Math.min(SHORTEST, whole)), whole);
    const begin = Math.min(Math.max(0.5 * (from + to - width), 0), whole - width);
    if (begin === this.from && begin + width === this.to) return;
    [this.from, this.to] = [begin, begin + width];
    this.draw();
  }

  // Keeps a place in sight while it moves on.
  follow(place) {
    const width = this.to - this.from;
    if (place < this.from || place > this.to) this.view(place - 0.1 * width, place + 0.9 * width);
  }

  draw() {
    const ink = this.canvas.getContext("2d"), { look } = this;
    ink.clearRect(0, 0, this.width, this.height);
    ink.font = `11.5px ${look.font}`;
    for (const row of this.shown) {
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

  // All of a curve, small, with what is seen of it.
  overview(ink, row, look) {
    ink.fillStyle = look.ground;
    ink.fillRect(LEFT, row.y, this.span, row.height);
    if (row.series) this.area(ink, row.series, 0, this.whole, row, 0, row.high, look.good);
    const a = LEFT + (this.from / this.whole) * this.span, b = LEFT + (this.to / this.whole) * this.span;
    ink.fillStyle = look.veil;
    ink.fillRect(LEFT, row.y, a - LEFT, row.height);
    ink.fillRect(b, row.y, LEFT + this.span - b, row.height);
    ink.strokeStyle = look.accent;
    ink.lineWidth = 1.5;
    ink.strokeRect(a + 0.75, row.y + 0.75, Math.max(b - a - 1.5, 2), row.height - 1.5);
  }

  within(ink, row, drawn) {
    ink.save();
    ink.beginPath();
    ink.rect(LEFT, row.y, this.span, row.height);
    ink.clip();
    drawn();
    ink.restore();
  }

  // Stretches with names: row.bars of { begin, end, colour, name }.
  bars(ink, row, look) {
    this.within(ink, row, () => {
      ink.textAlign = "left";
      for (const bar of row.bars) {
        if (bar.end < this.from || bar.begin > this.to) continue;
        const a = this.x(bar.begin), b = this.x(bar.end);
        ink.fillStyle = look.bars[bar.colour % look.bars.length];
        ink.fillRect(a, row.y, Math.max(b - a - 0.6, 0.6), row.height);
        if (b - a <= 34) continue;
        ink.fillStyle = look.onBar;
        ink.save();
        ink.beginPath();
        ink.rect(Math.max(a, LEFT), row.y, b - Math.max(a, LEFT) - 3, row.height);
        ink.clip();
        ink.fillText(bar.name, Math.max(a, LEFT) + 5, row.y + 13);
        ink.restore();
      }
    });
  }

  // A colour for each pixel, row.colour(place), and what the colours are in row.key of [name, colour].
  strip(ink, row, look) {
    let x = LEFT + this.span;
    ink.textAlign = "right";
    for (const [name, colour] of [...(row.key || [])].reverse()) {
      ink.fillStyle = look.soft;
      ink.fillText(name, x, row.y - 6);
      x -= ink.measureText(name).width + 15;
      ink.fillStyle = colour;
      ink.fillRect(x, row.y - 15, 10, 10);
      x -= 10;
    }
    for (let px = 0; px < this.span; px++) {
      ink.fillStyle = row.colour(this.place(LEFT + px + 0.5));
      ink.fillRect(LEFT + px, row.y, 1.2, row.height);
    }
  }

  // Curves between row.low and row.high, with marks [value, text] at the side and dashed bounds. Of each series:
  // values evenly over its `length` (the whole axis where it has none), colour(look), width, alpha, whether an area is
  // below.
  curves(ink, row, look) {
    const y = (v) => row.y + row.height * (1 - (v - row.low) / (row.high - row.low));
    ink.fillStyle = look.ground;
    ink.fillRect(LEFT, row.y, this.span, row.height);
    const across = (value) => {
      ink.beginPath();
      ink.moveTo(LEFT, y(value));
      ink.lineTo(LEFT + this.span, y(value));
      ink.stroke();
    };
    ink.strokeStyle = look.line;
    ink.lineWidth = 1;
    ink.fillStyle = look.soft;
    ink.textAlign = "right";
    for (const [value, text] of row.marks) {
      across(value);
      ink.fillText(text, LEFT - 6, y(value) + 4);
    }
    ink.strokeStyle = look.bad;
    ink.setLineDash([5, 4]);
    for (const bound of row.bounds || []) across(bound);
    ink.setLineDash([]);
    this.within(ink, row, () => {
      for (const series of row.series) if (series.area) this.area(ink, series, this.from, this.to, row, row.low, row.high, series.colour(look));
      for (const series of row.series) this.line(ink, series, y, series.colour(look), series.width || 1.3);
    });
    if (row.named) this.names(ink, row, look);
  }

  // What each colour is, at the end of the title's line.
  names(ink, row, look) {
    let x = LEFT + this.span;
    ink.textAlign = "right";
    for (const series of [...row.series].reverse()) {
      if (!series.name) continue;
      ink.fillStyle = series.colour(look);
      ink.fillText(series.name, x, row.y - 6);
      x -= ink.measureText(series.name).width + 12;
    }
  }

  // Least and largest of a series for each pixel, or its points where they are few.
  line(ink, series, y, colour, width) {
    const v = series.values, n = v.length, whole = series.length || this.whole;
    const first = Math.max(Math.floor((this.from / whole) * (n - 1)) - 1, 0);
    const last = Math.min(Math.ceil((this.to / whole) * (n - 1)) + 1, n - 1);
    ink.strokeStyle = colour;
    ink.lineWidth = width;
    ink.globalAlpha = series.alpha || 1;
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
    ink.globalAlpha = 1;
  }

  area(ink, series, from, to, row, low, high, colour) {
    const v = series.values, n = v.length, whole = series.length || this.whole;
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
    const step = this.step((this.to - this.from) / Math.max(this.span / 90, 1));
    for (let k = Math.ceil(this.from / step); k * step <= this.to; k++) {
      ink.fillText(this.label(k * step, step), this.x(k * step), this.height - 8);
    }
  }

  step(least) { return niceStep(least); }
  label(place, step) { return clock(place, step); }

  // Bars that are only moved: nothing is drawn anew while a motion is played.
  cursor() {
    const overview = this.shown[0], below = overview.y + overview.height + 4, places = [];
    for (const { place, colour } of this.cursors()) {
      const x = this.x(place), within = x >= LEFT && x <= LEFT + this.span;
      places.push({ x: LEFT + (place / this.whole) * this.span, y: overview.y, tall: overview.height, colour, within: true });
      places.push({ x, y: below, tall: this.height - 30 - below, colour, within });
    }
    places.forEach(({ x, y, tall, colour, within }, k) => {
      const bar = this.marks[k] ||= this.overlay.appendChild(document.createElement("i"));
      if (bar.hidden === within) bar.hidden = !within;
      const look = `${y} ${tall} ${colour}`;
      if (bar.look !== look) { Object.assign(bar.style, { top: `${y}px`, height: `${tall}px`, background: colour }); bar.look = look; }
      bar.style.transform = `translateX(${x - 0.75}px)`;
    });
    for (const bar of this.marks.splice(places.length)) bar.remove();
    const [{ place }] = this.cursors();
    this.element.setAttribute("aria-valuenow", place.toFixed(3));
    this.element.setAttribute("aria-valuetext", this.words(place));
  }

  listen() {
    const { overlay } = this;
    const at = (event) => {
      const box = overlay.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    let drag = null;
    overlay.addEventListener("pointerdown", (event) => {
      const [x, y] = at(event), overview = y < this.shown[0].y + OVERVIEW + 3;
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
    overlay.addEventListener("pointerup", (event) => {
      if (drag && !drag.moved && !drag.overview) this.choose(this.place(at(event)[0]));
      drag = null;
    });
    overlay.addEventListener("pointercancel", () => { drag = null; });
    overlay.addEventListener("pointerleave", () => { this.hint.hidden = true; });
    overlay.addEventListener("dblclick", () => this.view(0, this.whole));
    overlay.addEventListener("wheel", (event) => {
      event.preventDefault();
      const place = this.place(at(event)[0]), by = Math.exp(0.0016 * (event.deltaY + event.deltaX));
      this.view(place - (place - this.from) * by, place + (this.to - place) * by);
    }, { passive: false });
    new ResizeObserver(() => { if (this.element.clientWidth !== this.width) this.resize(); }).observe(this.element);
  }

  centre(x) {
    const place = ((x - LEFT) / this.span) * this.whole, half = 0.5 * (this.to - this.from);
    if (this.to - this.from < this.whole) this.view(place - half, place + half);
    else this.choose(place);
  }

  zoom(by) {
    const place = Math.min(Math.max(this.cursors()[0].place, this.from), this.to);
    this.view(place - (place - this.from) * by, place + (this.to - place) * by);
  }

  // What lies below the pointer, in words: of a row with tell(place) what that says, of curves their values.
  tell(x, y) {
    const place = this.place(x), row = this.shown.find((r) => y >= r.y - 4 && y <= r.y + r.height + 4);
    if (!row || x < LEFT || x > LEFT + this.span || row.kind === "overview") { this.hint.hidden = true; return; }
    const lines = [this.words(place)];
    if (row.tell) lines.push(row.tell(place));
    for (const series of row.kind === "curves" ? row.series : []) {
      const v = series.values[Math.round((place / (series.length || this.whole)) * (series.values.length - 1))];
      if (v !== undefined && !Number.isNaN(v)) lines.push(series.name ? `${series.name}: ${series.tell(v)}` : series.tell(v));
    }
    this.hint.textContent = lines.join("\n");
    this.hint.hidden = false;
    this.hint.style.left = `${Math.min(x + 14, this.width - this.hint.offsetWidth - 4)}px`;
    this.hint.style.top = `${Math.min(y + 14, this.height - this.hint.offsetHeight - 4)}px`;
  }
}

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
