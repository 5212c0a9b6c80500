// The program as text, of which the line that runs is lit, and what its time goes to.
const ROW = 20;

// A list of which only the rows in sight are elements.
class Listing {
  constructor(element, count, fill, choose) {
    Object.assign(this, { element, count, fill, choose });
    this.lit = -1;
    this.inner = document.createElement("div");
    this.inner.className = "inner";
    this.inner.style.height = `${count * ROW}px`;
    element.replaceChildren(this.inner);
    element.addEventListener("scroll", () => this.draw());
    element.addEventListener("click", (event) => {
      const row = event.target.closest(".row");
      if (row) choose(Number(row.dataset.k));
    });
    new ResizeObserver(() => this.draw()).observe(element);
  }

  draw() {
    const first = Math.max(Math.floor(this.element.scrollTop / ROW) - 4, 0);
    const last = Math.min(first + Math.ceil(this.element.clientHeight / ROW) + 8, this.count);
    const rows = [];
    for (let k = first; k < last; k++) {
      const row = document.createElement("div");
      row.className = k === this.lit ? "row lit" : "row";
      row.dataset.k = k;
      row.style.top = `${k * ROW}px`;
      this.fill(row, k);
      rows.push(row);
    }
    this.inner.replaceChildren(...rows);
  }

  light(k) {
    if (k === this.lit) return;
    this.lit = k;
    const y = k * ROW, { element } = this;
    if (k >= 0 && (y < element.scrollTop || y + ROW > element.scrollTop + element.clientHeight)) {
      element.scrollTop = Math.max(y - 0.35 * element.clientHeight, 0);
    }
    this.draw();
  }
}

function cell(text, kind) {
  const span = document.createElement("span");
  span.className = kind;
  span.textContent = text;
  return span;
}

class Program {
  constructor(player, element, text) {
    this.player = player;
    this.lines = text;
    const costs = player.lineTimes, top = Math.max(...costs.values(), 1e-12);
    this.list = new Listing(element, text.length, (row, k) => {
      const time = costs.get(k + 1) || 0, bar = cell("", "cost");
      bar.style.width = `${(46 * time) / top}px`;
      row.append(cell(String(k + 1), "number"), cell(text[k], "code"), bar);
      if (!time) row.classList.add("still");
    }, (k) => this.go(k + 1));
  }

  // To the next time at which a line is passed, or the first.
  go(line) {
    const { t } = this.player, begins = this.player.lineBegins.get(line);
    if (begins) this.player.seek(begins.find((b) => b > t + 1e-9) ?? begins[0]);
  }

  light(line) { this.list.light(line - 1); }
}

// What takes longest, each with a way there: blocks, operations, and places slower than the feed.
function costTables(player) {
  const excerpt = (line) => (player.text ? (player.text[line - 1] || "").trim() : "");
  const share = (time) => `${((100 * time) / player.duration).toFixed(1)} %`;
  const seconds = (time) => (time < 60 ? `${figure(time)} s` : clock(time, 1));
  const blocks = [...player.lineTimes].filter(([line]) => line > 0).sort((a, b) => b[1] - a[1]).slice(0, 60)
    .map(([line, time]) => ({ t: player.lineBegins.get(line)[0], cells: [`line ${line}`, excerpt(line), seconds(time), share(time)] }));
  const operations = [...player.operationTimes].sort((a, b) => b[1].time - a[1].time)
    .map(([k, each]) => ({ t: each.begin, cells: [player.operationName(k), player.operations[k].tool ? `tool ${player.operations[k].tool}` : "", seconds(each.time), share(each.time)] }));
  const slow = player.slowPlaces().slice(0, 60)
    .map((each) => ({ t: each.t, cells: [`line ${player.lineAt(each.t)}`, each.limit || "no limit reached", `${seconds(each.lost)} lost`, `${Math.round(100 * each.share)} % of F`] }));
  return { blocks, operations, slow };
}
