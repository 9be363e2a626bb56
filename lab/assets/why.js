// What the model lacks: verdict, suspects, reasons, effects, and the staircase of the error.
import { byId, el, table } from "./dom.js";
import { get } from "./server.js";
import { axis, colour, draw, layout, onTheme } from "./plots.js";
import { remainder } from "./remainder.js";

const panel = byId("panel-why");
let begin = () => {};
let goOn = () => {};
let addLog = () => {};
let bench = null;
let found = null;
let library = [];
let redrawPlots = [];
// How many series of the staircase are named in it.
const NAMED_STAIRS = 3;

/** `next` shows the design of the controller; `record` shows where logs are dropped. */
export async function start(work, next, record) {
  begin = work;
  goOn = next;
  addLog = record;
  library = await get("/api/effects");
  onTheme(() => redrawPlots.forEach((call) => call()));
}

export async function setBench(state) {
  bench = state;
  found = state.has_diagnosis ? await get("/api/diagnosis") : null;
  build();
}

/** Plots get their size when the panel is seen. */
export const shown = () => redrawPlots.forEach((call) => call());

const about = (name) => library.find((one) => one.name === name);
/** A plot that is folded away has no size yet. */
const drawn = (holder) => holder.offsetParent !== null;
const button = (text, task, main = false) => el("button", { type: "button", class: main ? "main" : null, onclick: () => begin(task) }, text);

function build() {
  redrawPlots = [];
  panel.replaceChildren(
    el("div", { class: "row" }, button(found ? "Diagnose again" : "Diagnose", { task: "diagnose" }, !found),
      found?.can_apply && (found.added.length || found.taken_out.length) ? button(applyText(), { task: "apply" }, true) : null),
    found ? verdict() : el("p", { class: "quiet" }, "The diagnosis looks for physical effects that the model lacks. It gives the probability of each, and names the experiment that would decide between those that fit equally well."),
    found?.missing_torque ? remainder(found.missing_torque, begin, redrawPlots, bench.effects.includes(`learned-${found.missing_torque.coordinate.replace("_", "-")}`), bench.opened) : "",
    tie(), found ? suspects() : "", found ? reasons() : "", model(), staircase(), others(),
  );
  redrawPlots.forEach((call) => call());
}

function applyText() {
  const out = found.taken_out.length ? ` and remove ${found.taken_out.join(", ")}` : "";
  return found.added.length ? `Add ${found.added.join(" + ")}${out}` : `Remove ${found.taken_out.join(", ")}`;
}

function verdict() {
  return el("div", {},
    el("div", { class: "verdict", id: "verdict", "data-verdict": found.verdict }, sentences(found.sentence).map((one) => el("p", {}, one))),
    found.current ? null : el("p", { class: "bad small" }, "The model has changed since: diagnose again."),
    found.remains ? el("p", {}, found.remains) : null,
    found.ambiguous_between.length ? el("div", { class: "card" }, el("h3", {}, "Equally good explanations"),
      found.ambiguous_between.map((set) => el("details", {}, el("summary", {}, set.join(" + ")), set.map((name) => [el("strong", { class: "small" }, name), lesson(name)])))) : null,
    found.next_experiment ? nextExperiment() : null,
    found.current && !found.can_apply && ["explained", "nothing-missing"].includes(found.verdict) ? onward() : null);
}

/** A verdict of several sentences, one a line: a sentence ends at a full stop before a capital letter or a command. */
const sentences = (text) => text.split(/(?<=\.) (?=[A-Z`])/);

/** What comes next where nothing is missing any more. */
function onward() {
  return el("div", { class: "hint row" }, el("span", { class: "grow small" }, "The model explains these measurements. The next step is the controller."),
    el("button", { type: "button", class: "main", id: "onward", onclick: goOn }, "Design it"));
}

/** The experiment that settles what is open: what to do, for how long, and what each explanation would show. */
function nextExperiment() {
  const recipe = found.recipe;
  if (!recipe) return el("div", { class: "card" }, el("h3", {}, "Next experiment"), el("p", {}, found.next_experiment), logButton());
  const holder = el("div", { class: "plot", role: "img", "aria-label": `What each explanation predicts for the ${recipe.channel}` });
  const lines = () => recipe.answers.map((answer, index) => ({ x: recipe.time_s, y: answer, mode: "lines", name: recipe.names[index], line: { color: colour(["model", "ghost", "push", "good"][index % 4]), width: 1.6, dash: ["solid", "dot", "dash", "dashdot"][index % 4] } }));
  redrawPlots.push(() => draw(holder, lines(), layout({ xaxis: axis("time (s)", { exponentformat: "none" }), yaxis: axis(`${recipe.channel} (${recipe.unit})`) }), { displayModeBar: false }));
  return el("div", { class: "card", id: "recipe" }, el("h3", {}, "The experiment that settles it"), el("p", {}, `Record ${recipe.experiment}.`),
    el("ol", { class: "small" }, recipe.steps.map((step) => el("li", {}, step))),
    el("p", { class: "small" }, `The first two explanations differ in the ${recipe.channel} by ${recipe.difference}. `, recipe.widest ?? ""), holder, logButton());
}

const logButton = () => el("button", { type: "button", class: "add-log", onclick: () => addLog() }, "Add the recorded log …");

function tie() {
  if (!bench.provisional.length) return "";
  return el("div", { class: "card" }, el("h3", {}, "Undecided"),
    el("p", {}, `${bench.provisional.join(" + ")} is in the model until an experiment decides.`),
    el("div", { class: "row" }, button(`Confirm ${bench.provisional[0]}`, { task: "add", effect: bench.provisional[0] }),
      bench.rivals.map((set) => button(`Try ${set.join(" + ")} in its place`, { task: "add", effect: set[0] }))));
}

function model() {
  const rows = bench.effects.map((name) => {
    const base = bench.base_effects.includes(name);
    return el("li", {}, name, bench.provisional.includes(name) ? " (provisional) " : " ",
      base ? el("span", { class: "quiet small" }, "base model") : button("Remove", { task: "remove", effect: name }));
  });
  return el("div", {}, el("h2", {}, "Effects of the model"), el("ul", { id: "model-effects" }, rows));
}

/** A long name without its middle: its end is the channel. */
const cut = (name) => (name.length > 44 ? `${name.slice(0, 26)}…${name.slice(-16)}` : name);

function staircase() {
  const { labels, rows } = bench.staircase;
  const holder = el("div", { class: "plot stairs", id: "staircase", role: "img", "aria-label": "RMSE over the sensor's noise after each change; the numbers are in the table below" });
  // The worst have a colour and their name; the others are there, and do not compete with them.
  const height = (row) => Math.max(...row.cells.map((cell) => cell.over_noise ?? 0));
  const worst = [...rows].sort((a, b) => height(b) - height(a)).slice(0, NAMED_STAIRS);
  const tone = (row) => colour(["model", "ghost", "push"][worst.indexOf(row)] ?? "measured");
  redrawPlots.push(() => draw(holder,
    [...rows.map((row) => ({
      x: labels.map((_, index) => index), y: row.cells.map((cell) => cell.over_noise), name: cut(row.series), showlegend: worst.includes(row),
      mode: "lines+markers", line: { shape: "hv", width: worst.includes(row) ? 2 : 1, color: tone(row) }, hovertemplate: "%{y:.3g} × noise<extra>%{fullData.name}</extra>",
    }))],
    layout({
      margin: { l: 56, r: 12, t: 70, b: 60 }, legend: { orientation: "v", x: 0, y: 1.02, yanchor: "bottom", font: { size: 11 } },
      xaxis: axis("", { tickvals: labels.map((_, index) => index), ticktext: labels.map((label) => (label.length > 22 ? `${label.slice(0, 21)}…` : label)), range: [-0.2, labels.length - 0.4] }),
      yaxis: axis("RMSE / noise", { type: "log", dtick: 1, exponentformat: "none" }),
      shapes: [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: 1, y1: 1, line: { color: colour("good"), dash: "dash", width: 1 } }],
    }), { displayModeBar: false }));
  const lines = rows.map((row) => el("tr", {}, el("td", {}, row.series),
    row.cells.map((cell) => el("td", { class: cell.fails ? "bad" : "good" }, cell.text)), el("td", {}, row.noise_text)));
  return el("div", {}, el("h2", {}, "The error after each change of the model"), holder,
    el("details", {}, el("summary", {}, "Numbers"), el("div", { class: "scroll stairs-numbers" }, table(["RMSE", ...labels, "sensor noise"], lines))));
}

const points = (all, name, tone, symbol, list = all.filter((p) => p[1] !== null)) => ({
  x: list.map((p) => p[0]), y: list.map((p) => p[1]), error_y: { array: list.map((p) => p[2]), visible: true, thickness: 1, width: 0 },
  mode: "markers", name, marker: { color: colour(tone), size: 6, symbol },
});

function figure(heading, traces, x, y, rangemode = "tozero") {
  const holder = el("div", { class: "plot", role: "img", "aria-label": heading });
  redrawPlots.push(() => drawn(holder) && draw(holder, traces(), layout({ xaxis: axis(x), yaxis: axis(y, { rangemode }) }), { displayModeBar: false }));
  return el("div", {}, el("h3", {}, heading), holder);
}

/** Residuals and decays; `names` are the series of the model as it was and of the model after. */
function pictures(residual, decay, names) {
  const [was, after] = names;
  const residuals = residual.map((one) => figure(`${one.experiment}: ${one.residual} over ${one.coordinate}`,
    () => [points(one.before, was, "model", "circle"), ...(one.after ? [points(one.after, after, "ghost", "diamond-open")] : [])],
    `${one.coordinate} (${one.coordinate_unit})`, `${one.is_torque ? "torque" : "difference"}<br>(${one.unit})`));
  const over = (measured, model, other) => () => [points(measured, "measured", "measured", "circle"),
    ...(other ? [points(other, was, "model", "x")] : []), ...(model ? [points(model, after, "ghost", "diamond-open")] : [])];
  const decays = decay.flatMap((one) => [
    figure(`${one.experiment}: decay over amplitude`, over(one.rates, one.model_rates, one.other_rates), "amplitude (rad)", "decay rate (1/s)"),
    ...(one.periods.length ? [figure(`${one.experiment}: period of small swings over amplitude`, over(one.periods, one.model_periods, one.other_periods), "amplitude (rad)", "period (s)", "normal")] : []),
    one.law ? el("p", { class: "small quiet" }, `dA/dt = −(C + V A + Q A²): ${one.law}`) : "",
  ]);
  return [...residuals, ...decays];
}

function reasons() {
  const all = pictures(found.reasons, found.decay, ["before the diagnosis", "after it"]);
  return all.length ? el("details", { id: "reasons", ontoggle: () => redrawPlots.forEach((call) => call()) }, el("summary", {}, el("strong", {}, "Evidence: where the model before the diagnosis fails, and how the swings decay")), all) : "";
}

/** What an effect looks like, without and with it in the model. */
function fingerprint(effect) {
  const own = found.fingerprints.find((one) => one.effect === effect);
  if (!own) return button("Draw its fingerprint", { task: "fingerprint", effect });
  const all = pictures(own.reasons, own.decay, ["without it", "with it"]);
  const hold = el("details", { class: "fingerprint", open: true, ontoggle: () => redrawPlots.forEach((call) => call()) }, el("summary", {}, "Its fingerprint: the model without and with it"),
    all.length ? all : el("p", { class: "small" }, "Neither the residuals nor the decay of the swings differ visibly. The share of the error that this effect takes away stands above."));
  return hold;
}

function lesson(name) {
  const info = about(name);
  if (!info) return null;
  return el("dl", {}, el("dt", {}, "What it is"), el("dd", {}, info.meaning), el("dt", {}, "Equation"), el("dd", {}, info.equation),
    el("dt", {}, "What it looks like"), el("dd", {}, info.fingerprint), el("dt", {}, "Shows in"), el("dd", {}, info.shows_in.join(", ")),
    info.confused_with.length ? [el("dt", {}, "Easily taken for"), el("dd", {}, info.confused_with.join(", "))] : [],
    el("dt", {}, "Source"), el("dd", {}, info.source));
}

function suspects() {
  const cards = found.suspects.slice(0, 8).map((one) => {
    const share = Math.round(100 * one.probability);
    const present = bench.effects.includes(one.effect);
    const fill = el("div");
    fill.style.width = `${share}%`;
    return el("div", { class: "card", "data-suspect": one.effect },
      el("div", { class: "row" }, el("strong", { class: "grow" }, one.effect), `${share} %`,
        present ? el("span", { class: "good small" }, "in the model") : button("Add", { task: "add", effect: one.effect })),
      el("div", { class: "bar", "aria-hidden": "true" }, fill),
      el("p", { class: "small" }, one.fingerprint),
      el("p", { class: "small" }, one.parameters.map((text) => el("span", { style: "display:block" }, text))),
      one.takes_away.length ? el("p", { class: "small quiet" }, `takes away ${one.takes_away.map((part) => `${part.text} of ${part.series}`).join("; ")}`) : null,
      el("details", {}, el("summary", {}, "About this effect"), lesson(one.effect)),
      fingerprint(one.effect));
  });
  return el("div", {}, el("h2", {}, "Suspects"), cards.length ? cards : el("p", {}, "None: nothing is missing."));
}

function others() {
  const names = library.map((one) => one.name).filter((name) => !bench.effects.includes(name));
  const choice = el("select", { id: "effect-choice", "aria-label": "Effect to add", onchange: () => text.replaceChildren(lesson(choice.value) ?? "") }, names.map((name) => el("option", {}, name)));
  const text = el("div", {}, lesson(names[0]) ?? "");
  return el("div", {}, el("h2", {}, "All effects of the library"),
    el("div", { class: "row" }, choice, el("button", { type: "button", onclick: () => begin({ task: "add", effect: choice.value }) }, "Add")), text);
}
