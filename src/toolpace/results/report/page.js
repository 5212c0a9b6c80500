"use strict";
// Draws the charts from the data in the page. Curves are thinned to what the screen can show, keeping the least and
// the largest value of every stretch, and thinned anew whenever the view changes.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const phone = window.innerWidth < 620;
  const ink = "#17202e", soft = "#5b6778", line = "#e4e8ee", neutral = "#dfe3e9";
  const font = { family: getComputedStyle(document.body).fontFamily, size: phone ? 11 : 12, color: soft };
  const config = { responsive: true, displayModeBar: phone ? false : "hover", displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"] };
  const blocks = new Int32Array(bytes(data.blocks.data));
  const missing = -32768;

  const present = new Set(data.channels.map((c) => c.panel));
  const off = present.has("deviation");
  const panels = phone
    ? { feed: [0.84, 1], strip: [0.795, 0.82], velocity: [0.54, 0.76], acceleration: [0.27, 0.5], jerk: [0, 0.23] }
    : off ? { feed: [0.86, 1], strip: [0.81, 0.835], deviation: [0.68, 0.78], velocity: [0.465, 0.645], acceleration: [0.235, 0.42], jerk: [0, 0.19] }
      : { feed: [0.83, 1], strip: [0.775, 0.803], velocity: [0.53, 0.745], acceleration: [0.265, 0.48], jerk: [0, 0.215] };
  if (phone && off) Object.assign(panels, { deviation: [0.68, 0.76], velocity: [0.46, 0.645], acceleration: [0.235, 0.42], jerk: [0, 0.19] });
  const axes = { feed: "y", strip: "y2", velocity: "y3", acceleration: "y4", jerk: "y5", deviation: "y6" };

  const blockAt = (t) => blocks[Math.min(blocks.length - 1, Math.round((t / data.end) * (blocks.length - 1)))];
  const figure = (v) => Number(v.toPrecision(4)).toString();

  for (const c of data.channels) c.values = new Int16Array(bytes(c.data));

  // Least and largest of each of `count` stretches between two times, in the order in which they come.
  function thinned(channel, from, to, count) {
    const v = channel.values, n = v.length, end = data.end || 1;
    const first = Math.max(0, Math.floor((from / end) * (n - 1)) - 1);
    const last = Math.min(n - 1, Math.ceil((to / end) * (n - 1)) + 1);
    const x = [], y = [], text = [];
    const put = (i) => {
      const t = (i / Math.max(n - 1, 1)) * end;
      x.push(t);
      if (v[i] === missing) { y.push(null); text.push(""); return; }
      const value = v[i] * channel.scale;
      y.push(value);
      text.push(channel.panel === "deviation"
        ? `${channel.name} off the program: ${figure(value * channel.peak)} ${channel.unit} (${(100 * value).toFixed(0)} % of the tolerance)` +
          `<br>${t.toFixed(3)} s, block ${blockAt(t)}`
        : channel.panel === "feed"
        ? `${channel.name}: ${figure(value)} mm/min<br>${t.toFixed(3)} s, block ${blockAt(t)}`
        : `${channel.panel} of ${channel.name}: ${(100 * value).toFixed(1)} %<br>${figure(value * channel.peak)} ${channel.unit}` +
          `<br>${t.toFixed(3)} s, block ${blockAt(t)}`);
    };
    const many = last - first + 1;
    if (many <= 2 * count) {
      for (let i = first; i <= last; i++) put(i);
    } else {
      for (let k = 0; k < count; k++) {
        const a = first + Math.floor((k * many) / count), b = first + Math.floor(((k + 1) * many) / count);
        let low = a, high = a;
        for (let i = a + 1; i < b; i++) { if (v[i] < v[low]) low = i; if (v[i] > v[high]) high = i; }
        if (low === high) put(low); else { put(Math.min(low, high)); put(Math.max(low, high)); }
      }
    }
    return { x, y, text };
  }

  const time = document.getElementById("time");
  const stretches = () => Math.max(300, Math.min(1400, Math.round(time.clientWidth * 0.9)));

  const seen = new Set();
  const traces = data.channels.map((c) => {
    const drawn = thinned(c, 0, data.end, stretches());
    const feed = c.panel === "feed", cap = feed && c.name !== "tip speed", strays = c.panel === "deviation";
    const named = feed || (!strays && !seen.has(c.name));
    if (!feed && !strays) seen.add(c.name);
    return {
      type: "scatter", mode: "lines", ...drawn, hoverinfo: "text", yaxis: axes[c.panel], xaxis: "x",
      name: c.name, legendgroup: feed || strays ? c.name : "joint " + c.name, showlegend: named, connectgaps: false,
      fill: feed && !cap ? "tozeroy" : "none", fillcolor: "rgba(20,163,127,0.13)",
      line: cap ? { color: "#66748a", width: 1, shape: "hv" }
        : strays ? { color: c.joint === -1 ? "#17202e" : "#98a3b3", width: 1 }
        : { color: feed ? "#14a37f" : data.joint_colours[c.joint], width: feed ? 1.4 : 1.25 },
    };
  });

  const strip = new Int16Array(bytes(data.strip));
  const steps = data.limits.length + 1;
  const discrete = [];
  [neutral, ...data.colours].forEach((colour, k) => discrete.push([k / steps, colour], [(k + 1) / steps, colour]));
  const limitName = (k) => (k < 0 ? "no limit reached" : data.limits[k]);
  const columns = Array.from(strip, (_, k) => ((k + 0.5) * data.duration) / strip.length);
  traces.push({
    type: "heatmap", xaxis: "x", yaxis: "y2", x: columns, y: [0], z: [Array.from(strip)], zmin: -1.5, zmax: steps - 1.5,
    colorscale: discrete, showscale: false, hoverinfo: "text",
    text: [Array.from(strip, (k, i) => `${limitName(k)}<br>${columns[i].toFixed(3)} s, block ${blockAt(columns[i])}`)],
  });

  const speeds = data.channels.filter((c) => c.panel === "feed");
  const fastest = speeds.length ? speeds[0].top : 1;
  const highest = speeds.length > 1 ? Math.max(fastest, Math.min(speeds[1].top, 1.6 * fastest)) : fastest;
  const panelAxis = (name) => ({
    domain: panels[name], range: [-1.13, 1.13], tickvals: [-1, -0.5, 0, 0.5, 1],
    ticktext: ["−100 %", "", "0", "", "100 %"], fixedrange: true, gridcolor: "#f0f2f6", zeroline: true,
    zerolinecolor: line, anchor: "x", automargin: false,
  });
  const titles = { feed: "Speed of the tip, mm/min", strip: "What limits", velocity: "Velocity, share of the limit",
    acceleration: "Acceleration, share of the limit", jerk: "Jerk, share of the limit",
    deviation: "Off the program, share of the tolerance: tip (dark), tool axis (light)" };
  const limitLine = (name, y) => ({ type: "line", xref: "paper", x0: 0, x1: 1, yref: axes[name], y0: y, y1: y,
    line: { color: "#c92a3f", width: 1.4, dash: "5px,4px" }, opacity: 0.75, layer: "above" });
  const kinds = ["velocity", "acceleration", "jerk"].filter((k) => present.has(k));
  const layout = {
    font, margin: { l: phone ? 46 : 62, r: 12, t: phone ? 74 : 48, b: 40 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff",
    hovermode: "closest", dragmode: "zoom", hoverlabel: { bgcolor: "#16263f", bordercolor: "#16263f", font: { color: "#fff" } },
    legend: { orientation: "h", x: 0, y: phone ? 1.03 : 1.025, yanchor: "bottom", groupclick: "togglegroup", tracegroupgap: 0 },
    xaxis: { range: [0, data.end], anchor: "y5", domain: [0, 1], gridcolor: "#f0f2f6", zeroline: false, ticksuffix: " s",
      showspikes: true, spikemode: "across", spikethickness: 1, spikecolor: "#98a3b3", spikedash: "solid", spikesnap: "cursor" },
    yaxis: { domain: panels.feed, range: [0, 1.08 * highest], fixedrange: true, gridcolor: "#f0f2f6", zerolinecolor: line, nticks: 5,
      anchor: "x" },
    yaxis2: { domain: panels.strip, range: [-0.5, 0.5], fixedrange: true, showticklabels: false, ticks: "", showgrid: false, zeroline: false, anchor: "x" },
    yaxis3: panelAxis("velocity"), yaxis4: panelAxis("acceleration"), yaxis5: panelAxis("jerk"),
    ...(off ? { yaxis6: { domain: panels.deviation, range: [0, 1.08], tickvals: [0, 0.5, 1], ticktext: ["0", "", "100 %"], fixedrange: true,
      gridcolor: "#f0f2f6", zerolinecolor: line, anchor: "x" } } : {}),
    shapes: [...kinds.flatMap((k) => [limitLine(k, 1), limitLine(k, -1)]), ...(off ? [limitLine("deviation", 1)] : [])],
    annotations: Object.keys(panels).filter((k) => k === "strip" || present.has(k)).map((k) => ({
      text: titles[k], xref: "paper", x: 0, xanchor: "left", yref: "paper", y: panels[k][1], yanchor: "bottom", yshift: 1,
      showarrow: false, font: { size: phone ? 11 : 12, color: ink } })),
  };
  Plotly.newPlot(time, traces, layout, config).then(() => { window.toolpaceReady = (window.toolpaceReady || 0) + 1; });

  let waiting = 0;
  function redraw() {
    const [from, to] = time.layout.xaxis.range.map(Number);
    const drawn = data.channels.map((c) => thinned(c, Math.max(from, 0), Math.min(to, data.end), stretches()));
    const which = data.channels.map((_, k) => k);
    Plotly.restyle(time, { x: drawn.map((d) => d.x), y: drawn.map((d) => d.y), text: drawn.map((d) => d.text) }, which);
  }
  time.on("plotly_relayout", (change) => {
    if (!Object.keys(change).some((key) => key.startsWith("xaxis"))) return;
    clearTimeout(waiting);
    waiting = setTimeout(redraw, 30);
  });
  time.on("plotly_doubleclick", () => {
    Plotly.relayout(time, { "xaxis.range": [0, data.end] });
    return false;
  });

  const space = document.getElementById("space");
  if (!data.scene) {
    document.getElementById("space-panel").remove();
    return;
  }
  const s = data.scene;
  const floats = (text) => Array.from(new Float32Array(bytes(text)));
  const at = { x: floats(s.x), y: floats(s.y), z: floats(s.z) };
  const speed = floats(s.speed), limiting = Array.from(new Int16Array(bytes(s.limiting)));
  const t = floats(s.t), block = new Int32Array(bytes(s.block));
  const [wx, wy, wz] = s.whiskers.map((w) => floats(w).map((v) => (Number.isNaN(v) ? null : v)));
  const text = speed.map((v, k) => `${Math.round(v)} mm/min<br>${limitName(limiting[k])}<br>${t[k].toFixed(3)} s, block ${block[k]}`);
  const bySpeed = { color: speed, colorscale: [[0, "#3b1d72"], [0.25, "#2f6fed"], [0.5, "#14a3a3"], [0.75, "#7cc243"], [1, "#f6c62d"]],
    cmin: 0, cmax: s.top, width: 4, showscale: !phone,
    colorbar: { title: { text: "mm/min", side: "right" }, thickness: 12, len: 0.6, outlinewidth: 0, x: 1 } };
  const byLimit = { color: limiting, colorscale: discrete, cmin: -1.5, cmax: steps - 1.5, width: 4, showscale: false };
  const extent = (v) => v.reduce((m, x) => Math.max(m, x), -Infinity) - v.reduce((m, x) => Math.min(m, x), Infinity);
  const extents = [extent(at.x), extent(at.y), extent(at.z)];
  const ticks = (k) => Math.max(3, Math.round((8 * extents[k]) / Math.max(...extents, 1e-9)));
  const box = { showbackground: false, gridcolor: line, zerolinecolor: line, linecolor: "#c8cfd9", showspikes: false };
  const whiskers = { type: "scatter3d", mode: "lines", x: wx, y: wy, z: wz, hoverinfo: "skip", showlegend: false,
    line: { color: "#b4bdca", width: 2 } };
  const way = { type: "scatter3d", mode: "lines", ...at, text, hoverinfo: "text", showlegend: false, line: bySpeed };
  Plotly.newPlot(space, [whiskers, way], {
    font, margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "#fff", uirevision: "keep",
    hoverlabel: { bgcolor: "#16263f", bordercolor: "#16263f", font: { color: "#fff" } },
    scene: { aspectmode: "data", dragmode: "orbit", camera: { center: { x: 0, y: 0, z: -0.12 }, eye: { x: 1.1, y: -1.75, z: 1.05 }, up: { x: 0, y: 0, z: 1 } },
      xaxis: { ...box, title: { text: "X mm" }, nticks: ticks(0) }, yaxis: { ...box, title: { text: "Y mm" }, nticks: ticks(1) }, zaxis: { ...box, title: { text: "Z mm" }, nticks: ticks(2) } },
  }, config).then(() => { window.toolpaceReady = (window.toolpaceReady || 0) + 1; });

  const key = document.getElementById("key");
  const used = [...new Set(limiting)].sort((a, b) => a - b);
  for (const k of used) {
    const entry = document.createElement("span"), mark = document.createElement("i");
    mark.style.background = k < 0 ? neutral : data.colours[k];
    entry.append(mark, limitName(k));
    key.append(entry);
  }
  for (const button of document.querySelectorAll(".choice button")) {
    button.addEventListener("click", () => {
      if ("whiskers" in button.dataset) {
        const shown = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(shown));
        Plotly.restyle(space, { visible: shown }, [0]);
        return;
      }
      for (const other of document.querySelectorAll("[data-colour]")) other.setAttribute("aria-pressed", String(other === button));
      const limit = button.dataset.colour === "limiting";
      key.hidden = !limit;
      Plotly.restyle(space, { line: limit ? byLimit : bySpeed }, [1]);
    });
  }
})();
