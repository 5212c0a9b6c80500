// Draws a followed run from the data in the page, and plays it.
(() => {
  watchTheme();
  const data = JSON.parse(document.getElementById("data").textContent);
  const ink = "#17202e", soft = "#5b6778", line = "#e4e8ee";
  const strong = ["#14a37f", "#d0455b", "#7a5bd0", "#c98a1b"];
  const font = { family: getComputedStyle(document.body).fontFamily, size: 12, color: soft };
  const config = { responsive: true, displayModeBar: "hover", displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"] };
  const names = Object.keys(data.errors), kinds = Object.keys(data.used);
  const times = (values) => values.map((_, k) => (k / Math.max(values.length - 1, 1)) * data.end);
  const over = (values, rest) => ({ type: "scatter", mode: "lines", x: times(values), y: values, ...rest });
  const colour = (k) => strong[k % strong.length];

  const traces = names.map((name, k) => over(data.errors[name], {
    yaxis: "y", name: "error " + name, line: { color: colour(k), width: 1.2 }, hovertemplate: "%{y:.1f} µm<extra>" + name + "</extra>",
  })).reverse();
  kinds.forEach((kind, k) => {
    const axis = "y" + (k + 2), [path, own, both] = data.used[kind];
    const part = (values, name, rest) => traces.push(over(values, {
      yaxis: axis, name, legendgroup: name, showlegend: k === 0, hovertemplate: "%{y:.1f} %<extra>" + kind + ", " + name + "</extra>", ...rest,
    }));
    part(both, "path and correction", { line: { color: "#9aa7b8", width: 1 } });
    part(path, "path", { line: { color: "#2f6fed", width: 1 } });
    part(own, "correction", { line: { color: "#e08a1e", width: 1 }, fill: "tozeroy", fillcolor: "rgba(224,138,30,0.22)" });
  });
  traces.push(over(data.pace, { yaxis: "y5", name: "pace", line: { color: ink, width: 1.4 }, showlegend: false, hovertemplate: "%{y:.3f}<extra>pace</extra>" }));
  const axis = (domain, title, more) => ({ domain, title: { text: title, font: { size: 12 } }, gridcolor: line, zerolinecolor: line, rangemode: "tozero", ...more });
  const chart = document.getElementById("over-time");
  Plotly.newPlot(chart, traces, {
    font, margin: { l: 62, r: 16, t: 30, b: 40 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hovermode: "x unified",
    legend: { orientation: "h", x: 0, y: 1.045 },
    xaxis: { anchor: "y5", range: [0, data.end], gridcolor: line, ticksuffix: " s" },
    yaxis: axis([0.78, 1], "error [µm]"),
    yaxis2: axis([0.575, 0.735], "velocity [%]", { range: [0, 105] }),
    yaxis3: axis([0.375, 0.535], "acceleration [%]", { range: [0, 105] }),
    yaxis4: axis([0.175, 0.335], "jerk [%]", { range: [0, 105] }),
    yaxis5: axis([0, 0.135], "pace"),
    shapes: ["y2", "y3", "y4"].map((yref) => ({ type: "line", xref: "paper", x0: 0, x1: 1, yref, y0: 100, y1: 100, line: { color: "#c92a3f", width: 1, dash: "dot" } })),
  }, config);

  const way = document.getElementById("way");
  const plane = (points, rest) => ({ type: "scatter", mode: "lines", x: points[0], y: points[1], hoverinfo: "skip", ...rest });
  const drawn = [plane(data.way, { name: "path", line: { color: "#9aa7b8", width: 2.5 } })];
  names.forEach((name, k) => drawn.push(plane(data.off[name], { name: "tip " + name, line: { color: colour(k), width: 1.3 } })));
  names.forEach((name, k) => drawn.push({ type: "scatter", mode: "markers", x: [data.off[name][0][0]], y: [data.off[name][1][0]], showlegend: false, hoverinfo: "skip", marker: { size: 11, color: colour(k), line: { color: "#fff", width: 1.5 } } }));
  Plotly.newPlot(way, drawn, {
    font, margin: { l: 56, r: 16, t: 10, b: 40 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    legend: { orientation: "h", x: 0, y: 1.06 },
    xaxis: { gridcolor: line, zeroline: false, ticksuffix: " mm" },
    yaxis: { gridcolor: line, zeroline: false, ticksuffix: " mm", scaleanchor: "x" },
  }, config);
  document.getElementById("magnified").textContent =
    "The tip in the plane in which the path is widest; what it is off by is drawn " + data.times.toLocaleString("en") + " times as large.";

  const cursor = document.createElement("div");
  cursor.className = "cursor";
  chart.appendChild(cursor);
  const place = document.getElementById("place"), now = document.getElementById("now"), button = document.getElementById("play");
  let share = 0, playing = false, before = 0;
  const value = (values) => values[Math.min(values.length - 1, Math.round(share * (values.length - 1)))];
  function show() {
    const markers = names.map((_, k) => 1 + names.length + k);
    Plotly.restyle(way, { x: names.map((name) => [value(data.off[name][0])]), y: names.map((name) => [value(data.off[name][1])]) }, markers);
    const x = chart._fullLayout.xaxis, size = chart._fullLayout._size, at = x.l2p(share * data.end);
    cursor.hidden = at < 0 || at > x._length;
    cursor.style.left = size.l + at + "px";
    cursor.style.top = size.t + "px";
    cursor.style.height = size.h + "px";
    now.textContent = (share * data.end).toFixed(2) + " s · " + names.map((name) => name + " " + value(data.errors[name]).toFixed(0) + " µm").join(" · ") + " · pace " + value(data.pace).toFixed(2);
    place.value = String(Math.round(1000 * share));
  }
  function frame(t) {
    if (!playing) return;
    share += (t - before) / 1000 / data.end;
    before = t;
    if (share >= 1) { share = 1; toggle(false); }
    show();
    if (playing) requestAnimationFrame(frame);
  }
  function toggle(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    button.setAttribute("aria-pressed", String(on));
    if (on) { if (share >= 1) share = 0; before = performance.now(); requestAnimationFrame(frame); }
  }
  button.addEventListener("click", () => toggle(!playing));
  place.addEventListener("input", () => { toggle(false); share = Number(place.value) / 1000; show(); });
  chart.on("plotly_relayout", show);
  show();
})();
