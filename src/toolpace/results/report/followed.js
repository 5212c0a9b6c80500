// Draws a followed run from the data in the page, and plays it.
const STEP = 0.1;  // of the run, by the arrows [s]

class Run extends Playback {
  step(by) { this.seek(this.t + by * STEP); }
}

async function start() {
  const get = (id) => document.getElementById(id), data = JSON.parse(get("data").textContent, (_, v) => v ?? NaN), run = new Run(data.end);
  const names = Object.keys(data.errors), colour = (k) => STRONG[k % STRONG.length];
  const errors = names.map((name, k) => ({ name, values: data.errors[name], unit: "µm", colour: () => colour(k) }));
  const pace = { title: "Pace, share of the plan's speed", series: [{ name: "pace", values: data.pace, unit: "", colour: (look) => look.ink }] };
  const panels = [...(errors.length ? [{ title: "Error of the tip, µm", named: true, series: errors }] : []), ...limitPanels(data.used), pace];
  const tracks = new RunTracks(get("timeline"), data.end, panels);
  tracks.seek = (t) => run.seek(t);
  tracks.layOut();
  const plane = new Plane(get("plane"), [{ name: "path", x: data.way[0], y: data.way[1], colour: (look) => look.soft, width: 2.5 },
    ...names.map((name, k) => ({ name, x: data.off[name][0], y: data.off[name][1], colour: () => colour(k), width: 1.3 }))]);
  names.forEach((name, k) => {
    const entry = cell(name, "entry"), mark = document.createElement("i");
    mark.style.background = colour(k);
    entry.prepend(mark);
    get("names").append(entry);
  });
  const value = (values) => values[Math.min(values.length - 1, Math.round((run.t / data.end) * (values.length - 1)))];
  run.watchers.push((t) => {
    tracks.at = t;
    if (run.playing) tracks.follow(t);
    tracks.cursor();
    const ways = names.length ? names.map((name, k) => [data.off[name], colour(k)]) : [[data.way, STRONG[0]]];
    plane.dots = ways.map(([way, ink]) => ({ x: value(way[0]), y: value(way[1]), colour: ink }));
    plane.draw();
    showClock(run, [...names.map((name) => `${name} ${value(data.errors[name]).toFixed(0)} µm`), `pace ${value(data.pace).toFixed(2)}`]);
  });
  wireTransport(run, tracks, null);
  watchTheme(() => {
    tracks.readLook();
    tracks.draw();
    plane.draw();
  });
  window.toolpace = { seek: (t) => run.seek(t), play: () => run.play(), pause: () => run.pause(),
    state: () => ({ t: run.t, playing: !!run.playing, pace: value(data.pace), errors: Object.fromEntries(names.map((name) => [name, value(data.errors[name])])) }) };
  run.seek(0);
  window.toolpaceReady = true;
}

begin(start);
