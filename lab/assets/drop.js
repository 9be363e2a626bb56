// Dropped CSV files become a bench: preview, proposal with its reasons, correction by clicking, and the folder on a click.
import { el, table } from "./dom.js";
import { get, post, send } from "./server.js";
import { axis, colour, draw, layout, onTheme } from "./plots.js";
import { CONSTANTS, sketch } from "./sketch.js";

let begin = () => {};
let complain = () => {};
// What the user has said: values of [known], and the choices of files by their names.
let corrections = { known: {}, files: {} };
let decided = new Set();
let holder = null;
let typed = null;
// Whether the text of bench.toml cannot be read with these files.
let unread = false;
// Whether a proposal is being worked out, and whether something was corrected meanwhile.
let busy = false;
let again = false;
// The previews that are shown, each as the call that draws it.
let previews = [];

const KINDS = [
  ["free-swing", "free swing: the wheel is locked, the body swings about hanging"],
  ["spin-up", "spin-up: the body is clamped, the wheel is driven or coasts"],
  ["balance", "balance: upright, under a controller"],
  ["driven", "driven: everything free, about hanging, open loop"],
];
const CHANNELS = [["time", "time"], ["angle", "body angle"], ["rate", "body rate"], ["wheel_speed", "wheel speed"], ["wheel_angle", "wheel angle"], ["current", "motor current"]];

export function start(work, report) {
  begin = work;
  complain = report;
  onTheme(() => previews.forEach((paint) => paint()));
}

/** The part of the opening page for files. */
export function panel() {
  holder = el("div", { id: "dropped" });
  const pick = el("input", { type: "file", multiple: true, accept: ".csv,.txt,.tsv,.dat,.log", id: "drop-files", onchange: () => take(pick.files) });
  const zone = el("div", {
    class: "card drop",
    ondragover: (event) => { event.preventDefault(); zone.classList.add("over"); },
    ondragleave: () => zone.classList.remove("over"),
    ondrop: (event) => { event.preventDefault(); zone.classList.remove("over"); take(event.dataTransfer.files); },
  }, el("label", { for: "drop-files" }, "Drop CSV files here, or choose them: "), pick);
  get("/api/drop").then(show).catch(complain);
  return el("div", {}, el("h2", {}, "Begin with your logs"), zone, holder);
}

async function take(files) {
  complain(null);
  if (!holder.firstChild) holder.replaceChildren(el("p", { role: "status", class: "row" }, el("span", { class: "spinner", "aria-hidden": "true" }), `Reading ${files.length === 1 ? files[0].name : `${files.length} files`} …`));
  try {
    for (const file of files) {
      await send(`/api/drop?name=${encodeURIComponent(file.name)}`, file);
    }
  } catch (error) {
    complain(error);
  }
  await correct();
}

/** Has the whole proposed anew with what was corrected; typed text is let go. */
async function correct() {
  typed = null;
  again = true;
  allow();
  // One question at a time, and the latest wish waits: an answer to an earlier one would leave out what was typed since.
  if (busy) return;
  busy = true;
  let found = null;
  try {
    while (again) {
      again = false;
      found = await post("/api/drop/correct", corrections);
    }
  } catch (error) {
    complain(error);
  } finally {
    busy = false;
    again = false;
  }
  if (found) show(found); else allow();
}

/** Forgets one file with what was said of it, or all. */
async function forget(name = null) {
  if (name) delete corrections.files[name];
  else corrections = { known: {}, files: {} };
  decided = new Set([...decided].filter((key) => name && !key.startsWith(`${name}: `)));
  try {
    await send(`/api/drop${name ? `?name=${encodeURIComponent(name)}` : ""}`);
  } catch (error) {
    complain(error);
  }
  await correct();
}

function show(found) {
  if (!found.files.length) {
    holder.replaceChildren();
    return;
  }
  const lines = (name) => found.files.find((file) => file.name === name)?.lines ?? [];
  const clear = el("button", { type: "button", onclick: () => forget() }, found.files.length === 1 ? "Forget this file" : "Forget these files");
  if (!found.proposal) {
    holder.replaceChildren(el("p", { class: "bad", id: "drop-failure" }, found.failure),
      ...found.files.map((file) => el("div", { class: "row" }, el("details", { class: "grow" }, el("summary", {}, file.name), el("pre", {}, file.lines.join("\n"))), leaveOut(file.name))), clear);
    return;
  }
  const keep = holder.querySelector("#new-folder")?.value ?? "my-bench";
  const open = new Set([...holder.querySelectorAll("details[open]")].map((one) => one.dataset.part));
  const active = document.activeElement;
  const focused = active?.dataset?.focus;
  // What is being typed is in no correction yet.
  const halfTyped = focused && active.matches("input[type=number]") ? active.value : null;
  previews = [];
  const cards = found.proposal.experiments.map((one, index) => card(one, found.previews[index], lines(one.file), open, found.files.length > 1));
  holder.replaceChildren(
    ...found.refused.map((text) => el("p", { class: "bad" }, text)),
    ...cards, known(found.proposal.open ? null : found.open_ends), ...bench(found, keep, open, clear));
  const next = focused && holder.querySelector(`[data-focus="${CSS.escape(focused)}"]`);
  next?.focus();
  if (next && halfTyped !== null && halfTyped !== next.value) {
    next.value = halfTyped;
    // A browser reports no change of a value that was not typed into this element.
    next.addEventListener("blur", () => next.dispatchEvent(new Event("change")), { once: true });
  }
}

/** One file among several that are good may be none of them. */
function leaveOut(name) {
  return el("button", { type: "button", class: "leave-out", "aria-label": `Leave it out: ${name}`, onclick: () => forget(name) }, "Leave it out");
}

/** One file: what it is, what its columns are, and which part of it counts. */
function card(one, preview, lines, open, hasOthers) {
  const choices = structuredClone(one.choices);
  const change = () => { corrections.files[one.file] = choices; correct(); };
  const focus = (part) => ({ "data-focus": `${one.file}:${part}` });
  const kind = el("select", { "aria-label": `Kind of ${one.file}`, ...focus("kind"), onchange: () => { choices.kind = kind.value; change(); } },
    KINDS.map(([value, text]) => el("option", { value, selected: value === choices.kind }, text)));
  const units = Object.fromEntries(preview.units ?? []);
  const rows = CHANNELS.map(([channel, words]) => {
    const own = choices.columns.find((choice) => choice.channel === channel);
    const set = (column) => {
      choices.columns = choices.columns.filter((choice) => choice.channel !== channel && choice.column !== column);
      if (column) choices.columns.push({ channel, column, unit: own?.unit ?? null, reversed: own?.reversed ?? false });
      change();
    };
    const column = el("select", { "aria-label": `Column of the ${words}`, ...focus(`${channel}-column`), onchange: () => set(column.value) },
      el("option", { value: "" }, "–"), one.column_names.map((name) => el("option", { value: name, selected: name === own?.column }, name)));
    const unit = el("select", { "aria-label": `Unit of the ${words}`, disabled: !own, ...focus(`${channel}-unit`), onchange: () => { own.unit = unit.value; change(); } },
      (units[channel] ?? []).map((name, k) => el("option", { value: name, selected: own && (own.unit ?? units[channel][0]) === name }, name)));
    const sign = el("input", { type: "checkbox", disabled: !own, checked: own?.reversed, "aria-label": `Sign of the ${words} reversed`, ...focus(`${channel}-sign`), onchange: () => { own.reversed = sign.checked; change(); } });
    return el("tr", { class: own ? null : "quiet" }, el("td", {}, words), el("td", { class: "left" }, column), el("td", { class: "left" }, unit),
      el("td", { class: "left" }, channel === "time" ? "" : sign), el("td", { class: "left wrap small" }, own?.reason ?? ""));
  });
  const number = (key, label, unit, about, empty) => {
    const input = el("input", { type: "number", step: "any", value: choices[key] ?? "", placeholder: empty, "aria-label": `${label} in ${unit}`, ...focus(key), onchange: () => { choices[key] = input.value === "" ? null : input.valueAsNumber; change(); } });
    return el("label", { class: "row small", title: about }, label, input, unit);
  };
  const has = (channel) => choices.columns.some((choice) => choice.channel === channel);
  const plot = el("div", { class: "plot preview", role: "img", "aria-label": `Preview of ${one.file}; drag over it to choose the part that counts` });
  const paint = () => previewed(plot, preview, choices, change);
  const isEmpty = !preview.curves.length;
  if (!isEmpty) {
    previews.push(paint);
    requestAnimationFrame(paint);
  }
  return el("section", { class: "card", "data-file": one.file }, el("div", { class: "row" }, el("h3", { class: "grow" }, one.file), hasOthers ? leaveOut(one.file) : ""), el("div", { class: "row" }, kind, el("span", { class: "small quiet grow" }, choices.kind_reason)),
    ...one.questions.map((question) => ask(`${one.file}: ${question}`, question)),
    el("div", { class: "scroll" }, table(["channel", "column", "unit", "reversed", "why"], rows, ["column", "unit", "reversed", "why"])),
    isEmpty ? el("p", { class: "bad small" }, "No column is chosen for the body or the wheel: choose it in the table.") : plot,
    el("div", { class: "row" }, number("from_s", "use from", "s", "earlier samples are left out", "start"), number("until_s", "until", "s", "later samples are left out", "end"),
      has("angle") ? number("offset_rad", "add to the angle", "rad", "π where 0 is upright", "0") : "",
      has("current") ? "" : number("held_current_a", "current held at", "A", "0 where the motor was off", "unknown"),
      has("time") ? "" : number("time_step_s", "from line to line", "s", "there is no time column", "unknown"),
      choices.from_s !== null || choices.until_s !== null ? el("button", { type: "button", onclick: () => { choices.from_s = null; choices.until_s = null; change(); } }, "Use the whole log") : ""),
    el("details", { "data-part": `lines ${one.file}`, open: open.has(`lines ${one.file}`) }, el("summary", { class: "small" }, "first lines of the file, and all reasons"), el("pre", {}, lines.join("\n")),
      el("ul", { class: "small" }, one.reasons.map((reason) => el("li", {}, reason)))));
}

/** What the data leave open: the bench is written when it is decided. */
function ask(key, question) {
  const box = el("input", { type: "checkbox", checked: decided.has(key), onchange: () => { if (box.checked) decided.add(key); else decided.delete(key); allow(); } });
  return el("label", { class: "question" }, el("strong", {}, "To decide: "), question, el("span", { class: "row small" }, box, "I have checked it: what is set here is right."));
}

function allow() {
  const left = [...holder.querySelectorAll(".question input")].filter((box) => !box.checked).length;
  const words = [left ? `${left} ${left === 1 ? "question is" : "questions are"} to decide above` : "", unread ? "the logs cannot be read yet, see the check" : "", busy || again ? "reading what was corrected …" : ""].filter(Boolean);
  for (const id of ["make-bench", "add-logs"]) {
    const button = holder.querySelector(`#${id}`);
    if (button) button.disabled = words.length > 0;
  }
  const line = holder.querySelector("#open-questions");
  if (line) line.textContent = words.join("; ");
}

function previewed(plot, preview, choices, change) {
  if (!plot.isConnected || !preview.curves.length) return;
  const count = preview.curves.length;
  const high = 1 / count;
  const traces = preview.curves.map((curve, index) => ({ x: curve.x, y: curve.y, yaxis: index ? `y${index + 1}` : "y", mode: "lines", line: { color: colour("measured"), width: 1.2 }, hovertemplate: `%{y:.5~g}<extra>${curve.channel}</extra>` }));
  const form = layout({ showlegend: false, dragmode: "zoom", hovermode: "x unified", margin: { l: 70, r: 12, t: 6, b: 36 }, shapes: [], xaxis: axis(preview.time, { anchor: count > 1 ? `y${count}` : "y" }) });
  preview.curves.forEach((curve, index) => {
    form[index ? `yaxis${index + 1}` : "yaxis"] = axis(`${curve.channel.replace("_", " ")}${curve.unit ? ` (${curve.unit})` : ""}`, { domain: [1 - (index + 1) * high + 0.03, 1 - index * high], fixedrange: true, nticks: 4 });
  });
  const [first, last] = [preview.curves[0].x[0], preview.curves[0].x.at(-1)];
  const out = (x0, x1) => form.shapes.push({ type: "rect", xref: "x", x0, x1, yref: "paper", y0: 0, y1: 1, fillcolor: colour("measured"), opacity: 0.35, line: { width: 0 } });
  if (choices.from_s !== null) out(first, choices.from_s);
  if (choices.until_s !== null) out(choices.until_s, last);
  plot.style.height = `${60 + 105 * count}px`;
  draw(plot, traces, form, { displayModeBar: false }).then(() => plot.removeAllListeners("plotly_relayout").on("plotly_relayout", (moved) => {
    if (!("xaxis.range[0]" in moved) || preview.time !== "time (s)") return;
    const [from, until] = [moved["xaxis.range[0]"], moved["xaxis.range[1]"]].map(Number);
    choices.from_s = from > first ? Number(from.toPrecision(5)) : null;
    choices.until_s = until < last ? Number(until.toPrecision(5)) : null;
    change();
  }));
}

/** The constants, with a drawing, and what stays unknown. */
function known(openEnds) {
  const { drawing, mark } = sketch();
  const fields = CONSTANTS.map(({ key, symbol, unit, words, how }) => {
    const input = el("input", {
      type: "number", step: "any", id: `known-${key}`, "data-focus": `known-${key}`, value: corrections.known[key] ?? "",
      onfocus: () => mark(key), onblur: () => mark(null),
      onchange: () => { if (input.value === "") delete corrections.known[key]; else corrections.known[key] = input.valueAsNumber; correct(); },
    });
    return el("div", { class: "known", onpointerenter: () => mark(key), onpointerleave: () => mark(document.activeElement?.id?.slice(6) ?? null) },
      el("label", { for: `known-${key}` }, el("strong", {}, symbol), ` ${words} `, el("span", { class: "quiet small" }, `(${how})`)), el("span", { class: "row" }, input, el("span", { class: "small" }, unit)));
  });
  const earth = corrections.known.gravity === undefined
    ? el("button", { type: "button", onclick: () => { corrections.known.gravity = 9.81; correct(); } }, "g = 9.81 m/s²") : "";
  return el("section", { class: "card" }, el("h3", {}, "What you know of the pendulum"),
    el("p", { class: "small" }, "Leave empty what you do not know; it is identified from the logs where they show it. Hanging is α = 0, upright is α = π, and positive angles turn as the arrow does."),
    el("div", { class: "constants" }, drawing, el("div", {}, fields, earth)),
    !openEnds ? "" : openEnds.length ? el("div", {}, el("strong", {}, "What stays unknown: "), el("ul", { class: "small", id: "open-ends" }, openEnds.map((text) => el("li", {}, text)))) : el("p", { class: "good small" }, "With these logs and constants every parameter of the base model can be found."));
}

/** The text of bench.toml, what the check says of it, and the folder. */
function bench(found, folderName, open, clear) {
  const text = el("textarea", { id: "bench-text", rows: 22, spellcheck: "false", "aria-label": "bench.toml as proposed; correct it here" });
  text.value = typed ?? found.proposal.text;
  const findings = el("div", { "aria-live": "polite", id: "drop-findings" });
  const tell = (one) => {
    unread = Boolean(one.failure);
    told(one);
    allow();
  };
  const told = (one) => findings.replaceChildren(
    one.failure ? el("p", { class: "bad" }, "It cannot be read yet. ", one.failure, ". Choose columns in the table of the file, leave the file out, or edit the text below.") : "",
    one.findings?.length ? el("ul", {}, one.findings.map((finding) => el("li", { class: finding.severity === "refuse" ? "bad" : null }, `${finding.experiment ? `${finding.experiment}: ` : ""}${finding.sentence} ${finding.fix}`)))
      : one.failure ? "" : el("p", { class: "good" }, "The data agree with this description."));
  tell({ findings: found.proposal.findings, failure: found.proposal.open });
  let timer = 0;
  text.addEventListener("input", () => {
    typed = text.value;
    clearTimeout(timer);
    timer = setTimeout(() => post("/api/drop/check", { text: text.value }).then(tell).catch(complain), 300);
  });
  const folder = el("input", { type: "text", size: 40, id: "new-folder", value: folderName, "aria-label": "New folder", "data-focus": "new-folder" });
  requestAnimationFrame(allow);
  return [
    el("h3", {}, "What the check of the data says"), findings,
    el("details", { "data-part": "text", open: open.has("text") }, el("summary", {}, "bench.toml, as it will be written"),
      el("p", { class: "quiet small" }, "The text can be edited too; it is checked as you type. A correction above replaces it."), text),
    el("div", { class: "row write-bench" }, el("label", { for: "new-folder" }, "New folder"), folder, el("span", { class: "small quiet" }, `in ${found.here}`),
      el("button", { type: "button", class: found.bench ? null : "main", id: "make-bench", onclick: () => begin({ task: "create", folder: folder.value.trim(), text: text.value }) }, "Write and open"),
      found.bench ? el("button", { type: "button", class: "main", id: "add-logs", title: "puts these logs and their experiments into the bench that is open; what it knows of the pendulum stays", onclick: () => begin({ task: "add-logs", text: text.value }) }, `Add to ${found.bench}`) : "",
      el("span", { class: "small bad", id: "open-questions", role: "status" }), clear),
  ];
}
