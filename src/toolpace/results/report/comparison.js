// Draws the speed of each plan over the way of its tip, and how much later than the first it is there.
(() => {
  watchTheme();
  const plans = JSON.parse(document.getElementById("data").textContent);
  const soft = "#5b6778", line = "#e4e8ee";
  const font = { family: getComputedStyle(document.body).fontFamily, size: 12, color: soft };
  const config = { responsive: true, displayModeBar: "hover", displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"] };
  const layout = (title) => ({
    font, margin: { l: 62, r: 16, t: 10, b: 40 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hovermode: "x",
    legend: { orientation: "h", y: 1.08 }, showlegend: true,
    xaxis: { title: { text: "way of the tip [mm]", font: { size: 12 } }, gridcolor: line, zeroline: false },
    yaxis: { title: { text: title, font: { size: 12 } }, gridcolor: line, zerolinecolor: line },
  });
  const curve = (plan, [x, y], text) => ({
    type: "scatter", mode: "lines", x, y, name: plan.name, line: { color: plan.colour, width: 1.3 }, hovertemplate: `%{y:.5g} ${text}<extra>${plan.name.replace(/[<&]/g, "")}</extra>`,
  });
  const speed = document.getElementById("speed"), later = document.getElementById("later");
  Plotly.newPlot(speed, plans.filter((plan) => plan.speed).map((plan) => curve(plan, plan.speed, "mm/min")), layout("speed [mm/min]"), config);
  const behind = plans.filter((plan) => plan.later);
  if (!behind.length) return;
  later.hidden = false;
  Plotly.newPlot(later, behind.map((plan) => curve(plan, plan.later, "s")), layout("later than the first [s]"), config);
  let busy = false;
  const follow = (from, to) => from.on("plotly_relayout", (change) => {
    if (busy) return;
    const range = ["xaxis.range[0]", "xaxis.range[1]", "xaxis.autorange"].filter((key) => key in change);
    if (!range.length) return;
    busy = true;
    Plotly.relayout(to, Object.fromEntries(range.map((key) => [key, change[key]]))).then(() => { busy = false; });
  });
  follow(speed, later);
  follow(later, speed);
})();
