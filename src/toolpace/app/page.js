const $ = (id) => document.getElementById(id);
const OFTEN = 700, SELDOM = 2500;
const FEEDS = [
  ["program", "as the program says"], ["none", "as fast as the machine can"],
  ["air", "faster in air"], ["learned", "as loaded elsewhere in it"], ["limits", "as limits of the cut allow"],
  ["own", "another feed or factor"],
];
const CUT = ["air", "learned", "limits"];
const EFFORTS = [["low", "low: the smoothest path"], ["normal", "normal"], ["high", "high: a thorough optimisation"]];
const OPTIONS = {
  controller: (v) => v ? `Read it as a program of ${v}` : "Name its control",
  dialect: (v) => v ? `Read it as ${v}` : "Name its format",
  compensation: () => "Its points are those of the tool's centre",
  columns: () => "Name the columns", units: (v) => v ? `Lengths are in ${v}` : "Name the unit",
  "max-blocks": () => "Allow more blocks", feed: (v) => v ? `Take ${v} as its feed` : "Give a feed",
  setup: () => "Write a set-up sheet to fill in", "tool-length": () => "Give the length of the tool",
  lenient: () => "Read on where the meaning is certain", "skip-unknown": () => "Skip what is not read",
};
let state = null, chosen = location.hash.slice(1), comparison = null;
const forms = {}, drafts = {}, compared = new Set();

async function call(method, path, body) {
  let answer;
  try {
    answer = await fetch(path, { method, body });
  } catch {
    throw new Error("The app does not answer. Start it again: what has not ended goes on then.");
  }
  if (!answer.ok) {
    const reason = await answer.text();
    throw new Error(answer.status === 401 ? "The app was started anew. Go on in the page that it opened, or at the address that it printed." : reason);
  }
  return answer.json();
}
const trouble = (text) => { $("trouble").hidden = !text; $("trouble").textContent = text; };

/* Does something and shows what came of it; the error, where it went wrong. */
async function go(method, path, body) {
  try {
    const found = await call(method, path, body);
    trouble("");
    await refresh();
    return found;
  } catch (error) {
    trouble(error.message);
    return null;
  }
}

let lost = false;
async function refresh() {
  try {
    state = await call("GET", "/api/state");
    if (lost) { lost = false; trouble(""); }
  } catch (error) {
    lost = true;
    trouble(error.message);
    return;
  }
  show();
}
async function watch() {
  await refresh();
  const busy = state && (state.jobs.some((job) => job.state === "waiting" || job.state === "running") || state.parts.some((part) => part.inspecting));
  setTimeout(watch, busy ? OFTEN : SELDOM);
}

// files

async function upload(files) {
  const told = [];
  // Programs first: the others belong to one.
  const later = /\.(toml|stl|3mf|obj)$/i;
  for (const file of [...files].sort((a, b) => later.test(a.name) - later.test(b.name))) {
    if (state && file.size > state.largest) { told.push(`${file.name}: is too large; ${Math.floor(state.largest / 1e6)} MB at most are taken`); continue; }
    const beside = later.test(file.name) && chosen ? `&part=${encodeURIComponent(chosen)}` : "";
    if (!await file.slice(0, 1).arrayBuffer().catch(() => null)) { told.push(`${file.name}: cannot be read; drop the files of a folder, not the folder`); continue; }
    try {
      const found = await call("POST", `/api/files?name=${encodeURIComponent(file.name)}${beside}`, file);
      if (found.part) choose(found.part);
    } catch (error) {
      told.push(error.message.startsWith(file.name) ? error.message : `${file.name}: ${error.message}`);
    }
  }
  await refresh();
  trouble(told.join("\n"));
}
function choose(part) {
  if (part !== chosen) { compared.clear(); comparison = null; }
  chosen = part;
  history.replaceState(null, "", `#${part}`);
}

// what is shown

function show() {
  $("folder").textContent = state.folder;
  $("footer").textContent = `toolpace ${state.version} · everything is in the folder above, and nothing leaves this computer`;
  const running = state.jobs.filter((job) => job.state === "running").length, waiting = state.jobs.filter((job) => job.state === "waiting").length;
  $("queue").textContent = running + waiting ? `${running} running · ${waiting} waiting` : "no job is running";
  if (!state.parts.some((part) => part.id === chosen)) chosen = state.parts.length ? state.parts[state.parts.length - 1].id : "";
  put($("parts"), "parts", [state.parts.map((part) => [part.id, part.program, word(part)]), chosen], () => state.parts.map((part) =>
    h("button", { type: "button", "data-focus": part.id, "aria-current": String(part.id === chosen), onclick: () => { choose(part.id); show(); } },
      h("b", { title: part.program }, part.program), h("span", {}, word(part)))));
  const part = state.parts.find((each) => each.id === chosen);
  if (!part) { $("part").replaceChildren(); drawn.part = ""; return; }
  if (drawn.part !== part.id) {
    for (const key of Object.keys(drawn)) if (key !== "parts") delete drawn[key];
    drawn.part = part.id;
    $("part").replaceChildren(...["program", "sheet", "plan", "jobs"].map((name) => h("section", { class: "panel", id: name })));
  }
  put($("program"), "program", [part.program, part.inspection, part.inspecting, part.reading, form(part).machine], () => programPanel(part));
  put($("sheet"), "sheet", [part.sheet, part.beside, part.controller, part.tool, part.sheet_error, part.writing_sheet], () => sheetPanel(part));
  put($("plan"), "plan", [state.machines, state.materials, part.inspection && [part.inspection.machines, part.inspection.cut_lacks], part.tool, part.id], () => planPanel(part));
  showJobs(part);
}
function word(part) {
  const found = part.inspection;
  if (!found) return "being inspected";
  if (found.error) return "not inspected";
  return `${found.dialect || "not known"} · ${found.refused.length ? `${found.refused.length} refused` : `${found.blocks} blocks`}`;
}
function form(part) {
  const found = part.inspection, machines = found && found.machines || [];
  forms[part.id] ??= { machine: "", tip_tolerance: "", axis_tolerance: "", feeds: "program", own: "3000mm/min", air_feed: "", limits: "", material: "", effort: "normal", tool_length: "", bend: false };
  const values = forms[part.id];
  // people have one machine: that of their last job
  const last = state.jobs.length ? state.jobs[state.jobs.length - 1].request.machine : "";
  if (!values.picked || !state.machines.includes(values.machine)) values.machine = machines.includes(last) ? last : machines[0] || "";
  return values;
}

function facts(rows) {
  return h("dl", { class: "facts" }, rows.filter((row) => row).flatMap(([name, value, kind]) => [h("dt", {}, name), h("dd", { class: kind || "" }, value)]));
}
const fold = (name, open, ...children) => h("details", { "data-fold": name, open }, ...children);
const list = (items) => h("ul", {}, items.map((item) => h("li", {}, item)));
const some = (items, count = 12) => items.length > count ? `${items.slice(0, count).join(", ")}, and ${items.length - count} more` : items.join(", ");

function programPanel(part) {
  const found = part.inspection;
  const head = h("div", { class: "head" }, h("h2", {}, part.program), button("Remove", () => {
    if (confirm(`Remove ${part.program} with all of its plans?`)) go("DELETE", `/api/parts/${part.id}`);
  }, "plain", { "data-focus": "remove" }));
  if (!found) return [head, h("p", { class: "lead" }, "It is being inspected.")];
  if (found.error) return [head, h("p", { class: "bad" }, found.error), readingForm(part)];
  const mm = (range) => `${range[0].toFixed(3)} to ${range[1].toFixed(3)}`;
  const rows = [
    ["control", `${found.dialect || "not known"}${found.reason ? `: ${found.reason}` : ""}`],
    ["blocks", `${found.blocks}, of them ${found.five_axis_blocks} turn the tool; ${found.arcs} arcs, ${found.stops} stops, ${found.dwells} dwells`],
    found.tools.length ? ["tools", some(found.tools)] : null,
    found.tip_mm ? ["tip, mm", found.tip_mm.map((range, k) => `${"XYZ"[k]} ${mm(range)}`).join(", ")] : null,
    found.refused.length
      ? ["refused", list(found.refused.slice(0, 40).map((each) => [h("b", {}, each.word), ` (line ${each.line}${each.count > 1 ? `, ${each.count} times` : ""}): ${each.cure}`].map(text))), "bad"]
      : ["refused", "nothing: every word is read", "good"],
    found.needs.length ? ["needs", list(found.needs), "bad"] : null,
    ["runs on", found.machines.length ? h("div", { class: "row" }, found.machines.map((name) => h("button", {
      type: "button", class: "chip", "data-focus": `on ${name}`, "aria-pressed": String(form(part).machine === name),
      onclick: () => { Object.assign(form(part), { machine: name, picked: true }); delete drawn.plan; show(); } }, name))) : "none of the machines that were tried", found.machines.length ? "" : "bad"],
  ];
  const folded = [
    found.assumed.length ? fold("assumed", false, h("summary", {}, `${found.assumed.length} assumed`), list(found.assumed)) : null,
    Object.keys(found.ignored).length ? fold("ignored", false, h("summary", {}, "words that move nothing"), some(Object.entries(found.ignored).map(([name, count]) => `${name} ${count}`), 40)) : null,
    Object.keys(found.not_on).length ? fold("not on", !found.machines.length && !found.refused.length, h("summary", {}, `${Object.keys(found.not_on).length} machines cannot run it`),
      list(Object.entries(found.not_on).map(([name, why]) => text([h("b", {}, name), `: ${why}`])))) : null,
  ];
  return [head, facts(rows), cures(part), applied(part), ...folded.filter((each) => each), readingForm(part)].filter((each) => each);
}
const text = (item) => item instanceof Node || typeof item === "string" ? item : h("span", {}, ...item);

/* The options that messages name, a button each. */
function cures(part) {
  const found = part.inspection;
  if (!found.cures.length) return null;
  return h("div", { class: "cures" }, h("p", {}, "What cures it:"), h("div", { class: "row" }, found.cures.flatMap((cure) => {
    const option = `--${cure.option}${cure.value ? ` ${cure.value}` : ""}`;
    const more = { title: option, "data-focus": `cure ${option}`, "data-cure": option };
    const made = [button(`${OPTIONS[cure.option](cure.value)} (${option})`, () => cureBy(part, cure), cure.option === "skip-unknown" ? "plain warn" : "plain", more)];
    if (cure.option === "feed") made.push(button("As fast as the machine can (--feed none)", () => cureBy(part, { option: "feed", value: "none" }), "plain", { "data-cure": "--feed none" }));
    return made;
  })));
}
function cureBy(part, cure) {
  const name = cure.option.replace("-", "_");
  if (cure.option === "feed" || cure.option === "tool-length") {
    if (cure.option === "feed") Object.assign(form(part), cure.value === "none" ? { feeds: "none" } : { feeds: "own", own: cure.value || "3000mm/min" });
    delete drawn.plan;
    show();
    $("plan").querySelector(cure.option === "feed" ? "[name=feeds]" : "[name=tool_length]").focus();
  } else if (cure.option === "setup") {
    go("POST", `/api/parts/${part.id}/sheet`);
    $("sheet").scrollIntoView({ block: "nearest" });
  } else if (cure.option === "skip-unknown" || cure.option === "lenient") {
    read(part, { [name]: true });
  } else if (cure.value) {
    read(part, { [name]: cure.value });
  } else {
    const folded = $("program").querySelector("[data-fold=reading]");
    folded.open = true;
    folded.querySelector(`[name=${name}]`).focus();
  }
}
const read = (part, change) => go("PUT", `/api/parts/${part.id}/reading`, JSON.stringify({ ...part.reading, ...change }));

/* What the user has chosen about reading, each to be taken back. */
function applied(part) {
  const set = Object.entries(part.reading).filter(([, value]) => value);
  if (!set.length) return null;
  return h("div", { class: "row", style: null }, h("span", { class: "quiet" }, "Read with"), set.map(([name, value]) =>
    h("button", { type: "button", class: "chip", title: "take it back", "data-focus": `take ${name}`, onclick: () => read(part, { [name]: typeof value === "boolean" ? false : name === "max_blocks" ? null : "" }) },
      `--${name.replace("_", "-")}${value === true ? "" : ` ${value}`} ×`)));
}

function field(name, label, values, change, more = {}, when = "onchange") {
  return h("label", {}, label, h("input", { type: "text", name, value: values[name] ?? "", spellcheck: "false", autocomplete: "off", maxlength: "200", "data-focus": name, [when]: (event) => change(event.target.value.trim()), ...more }));
}
function select(name, label, choices, value, change) {
  const made = h("select", { name, "data-focus": name, onchange: (event) => change(event.target.value) }, choices.map(([key, words, disabled]) => h("option", { value: key, disabled: !!disabled }, words)));
  made.value = value;
  return h("label", {}, label, made);
}
const check = (name, label, value, change) => h("label", { class: "check" }, h("input", { type: "checkbox", name, checked: value, "data-focus": name, onchange: (event) => change(event.target.checked) }), label);

function readingForm(part) {
  const reading = part.reading, set = (name) => (value) => read(part, { [name]: value });
  return fold("reading", false, h("summary", {}, "how it is read"), h("div", { class: "form" },
    select("controller", "control", [["", "as recognised"], ...state.controllers.map((name) => [name, name])], reading.controller, set("controller")),
    select("dialect", "format", [["", "as recognised"], ["gcode", "G-code"], ["apt", "APT, CLSF"], ["csv", "table of points"]], reading.dialect, set("dialect")),
    field("columns", "columns of a table: x,y,z,i,j,k", reading, set("columns")), field("units", "unit of a table: mm, m, in", reading, set("units")),
    field("max_blocks", "most blocks", { max_blocks: reading.max_blocks ?? "" }, (value) => read(part, { max_blocks: value ? Number(value) : null }), { inputmode: "numeric" }),
    check("compensation", "G41, G42: points of the tool's centre", reading.compensation === "program", (on) => read(part, { compensation: on ? "program" : "" })),
    check("lenient", "read on where the meaning is certain", reading.lenient, set("lenient")),
    check("skip_unknown", "skip what is not read", reading.skip_unknown, set("skip_unknown"))));
}

function sheetPanel(part) {
  const place = h("div", {});
  const edit = (text) => {
    drafts[part.id] = text;
    const area = h("textarea", { spellcheck: "false", "aria-label": "Set-up sheet", "data-focus": "sheet", oninput: () => { drafts[part.id] = area.value; } });
    const close = () => { delete drafts[part.id]; place.replaceChildren(); };
    const keep = async () => { if (await go("PUT", `/api/parts/${part.id}/sheet`, area.value)) close(); };
    area.value = text;
    place.replaceChildren(area, h("div", { class: "row" }, button("Keep it", keep, "plain", { "data-focus": "keep" }), button("Close", close, "plain", { "data-focus": "close" })));
    return area;
  };
  const open = async () => {
    const found = part.sheet ? await go("GET", `/api/parts/${part.id}/sheet`) : { text: "" };
    if (!found) return;
    const area = edit(found.text);
    area.setSelectionRange(0, 0);
    area.focus();
  };
  if (part.id in drafts) edit(drafts[part.id]);
  const buttons = [
    button(part.writing_sheet ? "It is being written" : "Write one to fill in", () => go("POST", `/api/parts/${part.id}/sheet`), "plain", { disabled: part.writing_sheet, "data-focus": "write" }),
    button(part.sheet ? "Show and change it" : "Type one", open, "plain", { "data-focus": "open" }),
    part.sheet ? button("Take it away", () => go("PUT", `/api/parts/${part.id}/sheet`, ""), "plain", { "data-focus": "away" }) : null,
  ].filter((each) => each);
  const files = [part.sheet ? `sheet: ${part.sheet}` : "no sheet: work offsets, tools and zero are assumed", part.controller ? `control: ${part.controller}` : "", part.tool ? `tool that bends: ${part.tool}` : "", part.beside.length ? `beside it: ${part.beside.join(", ")}` : ""];
  return [h("div", { class: "head" }, h("h2", {}, "Set-up sheet"), h("div", { class: "row" }, buttons)),
    h("p", { class: "lead" }, files.filter((each) => each).join(" · ")), part.sheet_error ? h("p", { class: "bad" }, part.sheet_error) : "", place];
}

function planPanel(part) {
  const values = form(part), fit = part.inspection && part.inspection.machines || [], lacks = part.inspection && part.inspection.cut_lacks || [];
  const feeds = FEEDS.map(([name, words]) => [name, words, CUT.includes(name) && lacks.length && values.feeds !== name]);
  const set = (name) => (value) => { values[name] = value; values.picked ||= name === "machine"; if (name === "feeds" || name === "machine") { delete drawn.plan; delete drawn.program; show(); } };
  const machines = [...(values.machine ? [] : [["", "choose a machine"]]), ...state.machines.map((name) => [name, fit.includes(name) ? name : `${name} (cannot run it)`])];
  const typed = (name, label, more) => field(name, label, values, set(name), more, "oninput");
  const start = async (event) => {
    event.preventDefault();
    const request = { machine: values.machine, tip_tolerance: values.tip_tolerance, axis_tolerance: values.axis_tolerance, effort: values.effort, tool_length: values.tool_length,
      feeds: values.feeds === "own" ? values.own : values.feeds, air_feed: CUT.includes(values.feeds) ? values.air_feed : "" };
    const byLimits = values.feeds === "limits";
    await ask(part, { ...request, limits: byLimits ? values.limits : "", material: byLimits ? values.material : "", bend: values.bend && !!part.tool });
  };
  return h("form", { onsubmit: start }, h("h2", {}, "Plan"), h("div", { class: "form" },
    select("machine", "machine", machines, values.machine, set("machine")),
    typed("tip_tolerance", "tolerance of the tip", { placeholder: "0.01mm, or less as it asks" }),
    typed("axis_tolerance", "tolerance of the tool axis", { placeholder: "0.05deg, or less as it asks" }),
    select("feeds", "feeds", feeds, values.feeds, set("feeds")),
    values.feeds === "own" ? typed("own", "feed (3000mm/min) or factor (120%)") : "",
    values.feeds === "limits" ? typed("limits", "limits of the cut, of all tools or one", { placeholder: "chip=0.08mm, 3:force=400N" }) : "",
    values.feeds === "limits" ? select("material", "material, for forces", [["", "none"], ...state.materials.map((name) => [name, name])], values.material, set("material")) : "",
    CUT.includes(values.feeds) ? typed("air_feed", "feed in air", { placeholder: "as the slowest axis" }) : "",
    select("effort", "effort", EFFORTS, values.effort, set("effort")),
    typed("tool_length", "tool length, without a sheet", { placeholder: "the machine's" }),
    part.tool ? check("bend", `compensate the bending by ${part.tool}`, values.bend, set("bend")) : ""),
  lacks.length ? h("p", { class: "lead" }, `Feeds by the cut need ${lacks.join(", ")}: write it into the set-up sheet.`) : "",
  h("button", { type: "submit", class: "plain main", "data-focus": "start" }, "Start"));
}

const ask = (part, request) => go("POST", `/api/parts/${part.id}/jobs`, JSON.stringify(request));

// jobs

function showJobs(part) {
  const jobs = state.jobs.filter((job) => job.part === part.id).reverse();
  $("jobs").hidden = !jobs.length;
  const first = [...jobs].reverse().find((job) => job.duration_s !== null);
  for (const id of compared) if (!jobs.some((job) => job.id === id && job.report)) compared.delete(id);
  const data = [jobs.map(({ steps, began, ...job }) => job), [...compared], comparison];
  put($("jobs"), "jobs", data, () => [
    h("div", { class: "head" }, h("h2", {}, "Plans"), h("div", { class: "row" },
      comparison ? comparison.drawn ? h("a", { class: "plain", target: "_blank", rel: "noopener", href: `/compare/${comparison.name}`, "data-focus": "compared" }, "Open the comparison") : h("span", { class: "quiet" }, "the comparison is being drawn") : "",
      button("Compare those that are ticked", compare, "plain", { disabled: compared.size < 2 || compared.size > 8, "data-focus": "compare" }))),
    ...jobs.map((job) => jobPanel(part, job, first))]);
  for (const job of jobs) {
    const place = document.getElementById(`steps-${job.id}`);
    if (place) put(place, `steps-${job.id}`, job.steps, () => progress(job));
  }
}
function jobPanel(part, job, first) {
  const request = job.request, ended = job.state === "ended" || job.state === "stopped";
  const act = (words, method, path) => button(words, () => go(method, path), "plain", { "data-focus": `${words} ${job.id}` });
  const buttons = [
    job.report ? h("a", { class: "plain", target: "_blank", rel: "noopener", href: `/report/${job.id}`, "data-focus": `look ${job.id}` }, "Look") : null,
    job.feeds_page ? h("a", { class: "plain", target: "_blank", rel: "noopener", href: `/feeds/${job.id}`, "data-focus": `feeds ${job.id}` }, "Feeds") : null,
    job.program ? h("a", { class: "plain", href: `/program/${job.id}`, download: "", "data-focus": `load ${job.id}` }, "Load program") : null,
    job.report && job.wider ? button(`Try ${job.wider.replace("um", " µm")}`, () => ask(part, { ...request, tip_tolerance: job.wider }), "plain", { title: "the same with twice the tolerance of the tip", "data-focus": `wider ${job.id}` }) : null,
    ended ? button("Change", () => change(part, request), "plain", { "data-focus": `change ${job.id}` }) : act("Stop", "POST", `/api/jobs/${job.id}/stop`),
    job.state === "stopped" || (ended && job.error) ? act("Again", "POST", `/api/jobs/${job.id}/again`) : null,
    ended ? act("Remove", "DELETE", `/api/jobs/${job.id}`) : null,
  ].filter((each) => each);
  const tick = job.report ? h("label", { class: "tick" }, h("input", { type: "checkbox", "aria-label": `compare job ${job.number}`, checked: compared.has(job.id), "data-focus": `tick ${job.id}`,
    onchange: (event) => { event.target.checked ? compared.add(job.id) : compared.delete(job.id); comparison = null; show(); } }), "compare") : "";
  const against = first && job.duration_s !== null && job.id !== first.id ? `${signed(100 * (job.duration_s / first.duration_s - 1))} % against job ${first.number}` : "";
  const outcome = job.duration_s !== null
    ? [h("b", { class: "time" }, seconds(job.duration_s)), h("span", { class: job.verdict === "verified" ? "good" : "bad" }, job.verdict), h("span", { class: "quiet" }, against)]
    : job.state === "running" ? h("div", { id: `steps-${job.id}`, class: "grow" })
    : job.state === "waiting" ? h("span", { class: "quiet" }, `waits, ${job.before} before it`)
    : job.state === "stopped" ? h("span", { class: "quiet" }, "stopped") : h("span", { class: "bad grow" }, job.error);
  const feeds = (FEEDS.find(([name]) => name === request.feeds) || [, `feed ${request.feeds}`])[1].split(" (")[0];
  const words = [`job ${job.number}`, request.machine, request.tip_tolerance ? `tip ${request.tip_tolerance}` : "usual tolerance", request.axis_tolerance ? `axis ${request.axis_tolerance}` : "", feeds, request.limits, request.material, request.air_feed ? `${request.air_feed} in air` : "", request.bend ? "bending compensated" : "", request.effort === "normal" ? "" : `effort ${request.effort}`,
    request.tool_length ? `tool ${request.tool_length}` : "", job.air_s === null ? "" : `${seconds(job.air_s)} of it at feed in air`, job.gap ? `at most ${job.gap} above the best possible` : "", job.limits ? `limited by ${job.limits}` : ""];
  return h("article", { class: "job" }, h("div", { class: "row top" }, tick, outcome, h("div", { class: "row buttons" }, buttons)),
    h("p", { class: "words" }, words.filter((word) => word).join(" · ")),
    job.notes.length ? fold(`about ${job.id}`, false, h("summary", {}, "about the program to load"), list(job.notes)) : "",
    job.command ? fold(`command ${job.id}`, false, h("summary", {}, "as a command"), h("code", {}, job.command)) : "");
}
function change(part, request) {
  const own = !FEEDS.some(([name]) => name === request.feeds);
  forms[part.id] = { own: "3000mm/min", picked: true, ...request, ...(own ? { feeds: "own", own: request.feeds } : {}) };
  delete drawn.plan; delete drawn.program;
  show();
  $("plan").querySelector("[name=tip_tolerance]").focus();
}
const signed = (value) => `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(2)}`;
function progress(job) {
  const done = job.steps.filter((step) => step.seconds !== undefined && step.step), now = job.steps.find((step) => step.seconds === undefined);
  const share = now && now.share !== undefined ? now.share : null;
  return [h("span", {}, now ? now.step : "begins"), h("span", { class: "quiet" }, now && now.note ? ` ${now.note}` : share === null ? "" : ` ${(100 * share).toFixed(0)} %`),
    bar(share), h("div", { class: "steps" }, done.map((step) => `${step.step} ${seconds(step.seconds)}`).join(", "))];
}
function bar(share) {
  const fill = h("span", {});
  if (share !== null) fill.style.width = `${100 * share}%`;
  return h("span", { class: share === null ? "meter unknown" : "meter", role: "progressbar" }, fill);
}
async function compare() {
  const jobs = state.jobs.filter((job) => compared.has(job.id)).map((job) => job.id);
  const found = await go("POST", "/api/compare", JSON.stringify(jobs));
  if (!found) return;
  const mine = comparison = { name: found.name, drawn: false };
  show();
  while (comparison === mine && !mine.drawn) {
    await new Promise((resolve) => setTimeout(resolve, 300));
    const answer = await call("GET", `/api/compare/${mine.name}`).catch((error) => error);
    if (answer instanceof Error) { comparison = null; trouble(answer.message); break; }
    if (answer.drawn) comparison = { ...mine, drawn: true };
  }
  show();
}

// the page itself

const dark = matchMedia("(prefers-color-scheme: dark)");
function theme(name) {
  document.documentElement.dataset.theme = name;
  $("theme").textContent = name === "dark" ? "Light" : "Dark";
}
theme(dark.matches ? "dark" : "light");
dark.addEventListener("change", () => theme(dark.matches ? "dark" : "light"));
$("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
$("file").addEventListener("change", async (event) => { await upload(event.target.files); event.target.value = ""; });
addEventListener("dragover", (event) => { event.preventDefault(); $("drop").classList.add("over"); });
addEventListener("dragleave", (event) => { if (!event.relatedTarget) $("drop").classList.remove("over"); });
addEventListener("drop", (event) => { event.preventDefault(); $("drop").classList.remove("over"); if (event.dataTransfer.files.length) upload(event.dataTransfer.files); });
watch();
