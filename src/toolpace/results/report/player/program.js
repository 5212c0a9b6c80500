// The program as text, of which the line that runs is lit, and what its time goes to.
const ROW = 20;
const TALLEST = 8e6;  // pixels of a list: browsers draw nothing beyond some 17 million
const WIDEST = 500;  // characters of a line that are shown: laying out a line of some MB takes seconds

// A list of which only the rows in sight are elements.
class Listing {
  constructor(element, count, fill, choose) {
    Object.assign(this, { element, count, fill, choose });
    this.lit = this.pale = -1;
    this.rows = new Map();
    this.inner = document.createElement("div");
    this.inner.className = "inner";
    this.tall = Math.min(count * ROW, TALLEST);
    this.inner.style.height = `${this.tall}px`;
    element.replaceChildren(this.inner);
    element.addEventListener("scroll", () => this.draw());
    element.addEventListener("click", (event) => {
      const row = event.target.closest(".row");
      if (row) choose(Number(row.dataset.k));
    });
    // also when it is shown again, which is when it can be scrolled
    new ResizeObserver(() => { this.reveal(); this.draw(); }).observe(element);
  }

  // How far the rows stand above their places in a list that would be too tall: all of it at its end.
  get above() {
    const { scrollTop, clientHeight } = this.element;
    return Math.min(scrollTop / Math.max(this.tall - clientHeight, 1), 1) * (this.count * ROW - this.tall);
  }

  draw() {
    const { above } = this, first = Math.max(Math.floor((this.element.scrollTop + above) / ROW) - 4, 0);
    const last = Math.min(first + Math.ceil(this.element.clientHeight / ROW) + 8, this.count);
    this.rows = new Map();
    for (let k = first; k < last; k++) {
      const row = document.createElement("div");
      row.className = "row";
      row.dataset.k = k;
      row.style.top = `${k * ROW - above}px`;
      this.fill(row, k);
      this.rows.set(k, row);
    }
    this.inner.replaceChildren(...this.rows.values());
    this.mark(true);
  }

  // Puts the marks on their rows, or takes them away.
  mark(on) {
    for (const [kind, k] of [["lit", this.lit], ["pale", this.pale]]) this.rows.get(k)?.classList.toggle(kind, on && (kind === "lit" || k !== this.lit));
  }

  // The row that is passed, which is kept in sight, and another one.
  light(k, pale = -1) {
    if (k === this.lit && pale === this.pale) return;
    this.mark(false);
    [this.lit, this.pale] = [k, pale];
    // scrolling draws the rows that come into sight
    this.reveal();
    this.mark(true);
  }

  // Scrolls to the lit row where that is out of sight.
  reveal() {
    const { element, lit, tall, count } = this, room = element.clientHeight, top = lit * ROW - this.above;
    if (lit < 0 || !room || (top >= element.scrollTop && top + ROW <= element.scrollTop + room)) return;
    const share = (tall - room) / Math.max(count * ROW - room, 1);
    element.scrollTop = Math.max(lit * ROW - 0.35 * room, 0) * share;
  }
}

function cell(text, kind) {
  const span = document.createElement("span");
  span.className = kind;
  span.textContent = text;
  return span;
}

// The largest of any number of values, which are more than a call takes arguments.
function largest(values) {
  let top = 1e-12;
  for (const value of values) if (value > top) top = value;
  return top;
}

class Program {
  constructor(player, element, text) {
    this.player = player;
    this.lines = text;
    const costs = player.lineTimes, top = largest(costs.values());
    this.list = new Listing(element, text.length, (row, k) => {
      const time = costs.get(k + 1) || 0, bar = cell("", "cost");
      bar.style.width = `${(46 * time) / top}px`;
      row.append(cell(String(k + 1), "number"), cell(text[k].slice(0, WIDEST), "code"), bar);
      if (!time) row.classList.add("still");
    }, (k) => this.go(k + 1));
  }

  go(line) {
    const t = this.player.lineTime(line);
    if (!Number.isNaN(t)) this.player.seek(t);
  }

  light(line, pale = 0) { this.list.light(line - 1, pale - 1); }
}

// What takes longest, each with a way there: blocks, operations, and places slower than the feed.
function costTables(player) {
  const excerpt = (line) => (player.text ? (player.text[line - 1] || "").slice(0, WIDEST).trim() : "");
  const share = (time) => `${((100 * time) / player.duration).toFixed(1)} %`;
  const seconds = (time) => (time < 60 ? `${figure(time)} s` : clock(time, 1));
  const blocks = [...player.lineTimes].filter(([line]) => line > 0).sort((a, b) => b[1] - a[1]).slice(0, 60)
    .map(([line, time]) => ({ t: player.lineBegins.get(line)[0], cells: [`line ${line}`, excerpt(line), seconds(time), share(time)] }));
  const operations = [...player.operationTimes].filter(([k]) => player.operations[k]).sort((a, b) => b[1].time - a[1].time).slice(0, 200)
    .map(([k, each]) => ({ t: each.begin, cells: [player.operationName(k), player.operations[k].tool ? `tool ${player.operations[k].tool}` : "", seconds(each.time), share(each.time)] }));
  const slow = player.slowPlaces().slice(0, 60)
    .map((each) => ({ t: each.t, cells: [`line ${player.lineAt(each.t)}`, each.limit || "no limit reached", `${seconds(each.lost)} lost`, `${Math.round(100 * each.share)} % of F`] }));
  return { blocks, operations, slow };
}
