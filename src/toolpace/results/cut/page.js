"use strict";
// Draws a cut from the data in the page.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const soft = "#5b6778", line = "#e4e8ee";
  const colours = ["#c3ccd8", "#14a37f", "#e0b13c", "#7a9cf0"];
  const font = { family: getComputedStyle(document.body).fontFamily, size: 12, color: soft };
  const config = { responsive: true, displayModeBar: "hover", displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"] };
  const count = data.rate.length, step = data.end / count;
  const times = data.rate.map((_, k) => (k + 0.5) * step);
  const over = (values, name, unit, rest) => ({
    type: "scatter", mode: "lines", x: times, y: values, name, line: { width: 1.2, ...rest.line }, showlegend: false,
    hovertemplate: "%{y:.4g} " + unit + "<extra>" + name + "</extra>", ...rest, line: { width: 1.2, shape: "hv", ...rest.line },
  });
  const traces = [
    { type: "heatmap", x: times, y: [0], z: [data.state.map((s) => (s < 0 ? null : s))], yaxis: "y", showscale: false, zmin: 0, zmax: 3, hoverongaps: false,
      colorscale: colours.flatMap((c, k) => [[k / 4, c], [(k + 1) / 4, c]]), text: [data.state.map((s) => data.states[s] || "at rest")], hovertemplate: "%{text}<extra></extra>" },
    over(data.rate, "removal rate", "cm³/min", { yaxis: "y2", line: { color: "#14a37f" }, fill: "tozeroy", fillcolor: "rgba(20,163,127,0.18)" }),
    over(data.depth, "depth", "mm", { yaxis: "y3", line: { color: "#7a5bd0" }, showlegend: true }),
    over(data.width, "width", "mm", { yaxis: "y3", line: { color: "#e08a1e" }, showlegend: true }),
    over(data.feed, "feed in the program", "mm/min", { yaxis: "y4", line: { color: "#9aa7b8", width: 2 }, showlegend: true }),
    over(data.speed, "speed of the tip", "mm/min", { yaxis: "y4", line: { color: "#2f6fed" }, showlegend: true }),
  ];
  data.states.forEach((name, k) => traces.push({ type: "scatter", mode: "markers", x: [null], y: [null], yaxis: "y2", name, marker: { symbol: "square", size: 11, color: colours[k] } }));
  const hits = data.findings;
  if (hits.length) {
    traces.push({ type: "scatter", mode: "markers", x: hits.map((f) => f.time), y: hits.map(() => 0), yaxis: "y", name: "collision", marker: { symbol: "x", size: 9, color: "#c92a3f" },
      text: hits.map((f) => f.text), hovertemplate: "%{text}<extra></extra>" });
  }
  const axis = (domain, title, more) => ({ domain, title: { text: title, font: { size: 12 } }, gridcolor: line, zerolinecolor: line, rangemode: "tozero", ...more });
  Plotly.newPlot("over-time", traces, {
    font, margin: { l: 66, r: 16, t: 34, b: 40 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hovermode: "x unified",
    legend: { orientation: "h", x: 0, y: 1.06 },
    xaxis: { anchor: "y4", range: [0, data.end], gridcolor: line, ticksuffix: " s" },
    yaxis: { domain: [0.95, 1], showticklabels: false, showgrid: false, zeroline: false, fixedrange: true, range: [-0.5, 0.5] },
    yaxis2: axis([0.66, 0.92], "removal [cm³/min]"),
    yaxis3: axis([0.34, 0.6], "engagement [mm]"),
    yaxis4: axis([0, 0.28], "speed [mm/min]"),
  }, config);

  const way = data.way, drawn = [];
  data.states.forEach((name, k) => {
    const pick = (values) => {
      const out = [];
      for (let i = 1; i < values.length; i++) if (way.state[i] === k) out.push(values[i - 1], values[i], null);
      return out;
    };
    const x = pick(way.x);
    if (x.length) drawn.push({ type: "scatter3d", mode: "lines", name, x, y: pick(way.y), z: pick(way.z), line: { color: colours[k], width: k === 1 ? 4 : 2.5 }, hoverinfo: "skip" });
  });
  if (hits.length) {
    drawn.push({ type: "scatter3d", mode: "markers", name: "collision", x: hits.map((f) => f.x[0]), y: hits.map((f) => f.x[1]), z: hits.map((f) => f.x[2]),
      marker: { symbol: "x", size: 5, color: "#c92a3f" }, text: hits.map((f) => f.text), hovertemplate: "%{text}<extra></extra>" });
  }
  // ways to a tool change are ten times as long as the part: the picture ends a little outside of the moves at feed
  const rapid = data.states.indexOf("rapid"), spans = [way.x, way.y, way.z].map((values) => {
    const at = values.filter((_, i) => way.state[i] !== rapid || way.state[Math.min(i + 1, values.length - 1)] !== rapid);
    return at.length ? [at.reduce((a, b) => Math.min(a, b)), at.reduce((a, b) => Math.max(a, b))] : null;
  });
  const margin = spans[0] && Math.max(1, 0.25 * Math.max(...spans.map(([low, high]) => high - low)));
  const side = (title, span) => ({ title: { text: title }, range: span ? [span[0] - margin, span[1] + margin] : undefined, gridcolor: line, zerolinecolor: line, showbackground: false });
  Plotly.newPlot("way", drawn, {
    font, margin: { l: 0, r: 0, t: 10, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)", legend: { orientation: "h", x: 0, y: 1 },
    scene: { aspectmode: "data", camera: { eye: { x: -1.3, y: -1.9, z: 1.5 }, projection: { type: "orthographic" } }, xaxis: side("X [mm]", spans[0]), yaxis: side("Y [mm]", spans[1]), zaxis: side("Z [mm]", spans[2]) },
  }, config);
})();
