// Overlay and residual of one experiment on one time axis. Zoom asks the server for what the screen can show.
import { byId, el } from "./dom.js";
import { ask } from "./server.js";
import { axis, colour, draw, layout, onTheme } from "./plots.js";
import { showErrors } from "./errors.js";
import { clear, paint } from "./moving.js";

const plot = byId("curves");
let bench = null;
let chosen = 0;
let view = { from_s: null, to_s: null };
let changes = [];
let onError = () => {};
// The model without moved sliders in this view: what stays as the ghost.
let ghost = null;
let shown = null;
// One question at a time; the latest wish waits.
let busy = false;
let wish = null;
// The errors with moved sliders, of the experiments that were simulated so far.
let moved = { changes, rows: [] };
let drawing = false;
// The hand rests when nothing has moved for this long, ms.
const RESTS = 250;
let rest = 0;

export function start(report) {
  onError = report;
  onTheme(() => { if (shown) redraw(); });
}

/** The place has become visible again: it may have another width. */
export function resize() {
  if (shown && plot.data) Plotly.Plots.resize(plot);
}

/** The bench as it is now; `fresh` where another one was opened. Moved sliders are told afterwards. */
export function setBench(state, fresh) {
  const name = bench?.experiments[chosen]?.name;
  bench = state;
  if (fresh) {
    view = { from_s: null, to_s: null };
    chosen = 0;
    const worst = state.places[0]?.experiment;
    if (worst) chosen = Math.max(0, state.experiments.findIndex((one) => one.name === worst));
  } else {
    chosen = Math.max(0, state.experiments.findIndex((one) => one.name === name));
  }
  changes = [];
  moved = { changes, rows: [] };
  ghost = null;
  buttons();
  request(true);
}

/** Other values of parameters: [[name, value], …]. */
export function setChanges(values) {
  changes = values;
  request(false);
}

function choose(name) {
  const index = bench.experiments.findIndex((one) => one.name === name);
  if (index < 0 || index === chosen) return;
  chosen = index;
  view = { from_s: null, to_s: null };
  ghost = null;
  buttons();
  request(true);
}

function buttons() {
  const worst = (name) => bench.errors.filter((row) => row.experiment === name).reduce((most, row) => (row.over_noise > most.over_noise ? row : most), { over_noise: 0, fails: false });
  const list = byId("experiments");
  list.replaceChildren(...bench.experiments.map((one, index) => {
    const row = worst(one.name);
    const over = row.over_noise;
    return el("button", {
      type: "button", "aria-pressed": String(index === chosen),
      title: `${one.kind}, ${one.samples} samples over ${one.duration_s.toPrecision(3)} s; the largest RMSE is ${over.toPrecision(3)} times the noise of its sensor`,
      onclick: () => choose(one.name),
    }, `${one.name} `, el("span", { class: row.fails ? "bad" : "good" }, `×${over < 10 ? over.toPrecision(2) : Math.round(over)}`));
  }));
  // Many experiments scroll in their own list, which shows the chosen one.
  const own = list.children[chosen];
  if (own && (own.offsetTop < list.scrollTop || own.offsetTop + own.offsetHeight > list.scrollTop + list.clientHeight)) list.scrollTop = own.offsetTop;
}

/**
 * Asks for the curves, and shows them. `anew`: other axes or marks; `rested`: the library draws, and the other experiments
 * follow, as when the hand has come to rest. Else a moved curve follows the hand on a canvas.
 */
async function request(anew, rested = anew) {
  wish = { anew: anew || (wish?.anew ?? false), rested: rested || (wish?.rested ?? false) };
  if (busy) return;
  busy = true;
  try {
    while (wish) {
      const { anew: all, rested: rests } = wish;
      wish = null;
      // The library knows its width; asking the page for it would lay the page out anew at every move.
      const width = plot._fullLayout?.width ?? plot.clientWidth;
      const question = { experiment: chosen, ...view, pixels: Math.max(200, width - 90) };
      if (!ghost) ghost = await ask({ ...question, changes: [] });
      if (wish?.anew) continue;
      const asked = changes;
      const isMoved = asked.length > 0;
      const now = isMoved ? await ask({ ...question, changes: asked, model_only: true }) : ghost;
      if (wish && (wish.anew || !ghost)) {
        wish.rested ||= rests;
        continue;
      }
      const first = !shown || all;
      const follows = isMoved && !all && !rests && Boolean(shown);
      if (isMoved) now.channels.forEach((channel, index) => { channel.measured = ghost.channels[index].measured; });
      shown = now;
      clearTimeout(rest);
      if (!(follows && paint(plot, now, ghost))) {
        if (!wish) await settle(first);
        else wish.anew ||= first;
      }
      if (follows) rest = setTimeout(() => request(false, true).catch(onError), RESTS);
      rate(asked, now.errors);
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn ?? 0) + 1);
      if (isMoved && !follows) await others(asked);
    }
  } catch (error) {
    onError(error);
  } finally {
    busy = false;
  }
}

/** Shows the errors: all of the fitted model, or those with moved sliders that are known so far. */
function rate(asked, errors) {
  if (moved.changes !== asked) moved = { changes: asked, rows: [] };
  const fresh = new Set(errors.map((row) => row.experiment));
  moved.rows = [...moved.rows.filter((row) => !fresh.has(row.experiment)), ...errors];
  if (ghost) showErrors(moved.rows, asked.length ? ghost.errors : null, bench.experiments[chosen].name, choose);
}

/** The errors of the other experiments, one after another: they make way as soon as the hand moves again. */
async function others(asked) {
  for (const [experiment, { name }] of bench.experiments.entries()) {
    if (wish) return;
    if (moved.rows.some((row) => row.experiment === name)) continue;
    const found = await ask({ experiment, from_s: null, to_s: null, pixels: 1, changes: asked, model_only: true });
    if (!wish) rate(asked, found.errors);
  }
}

function curvesOf(index) {
  const channel = shown.channels[index];
  const empty = { x: [], y: [] };
  const isMoved = changes.length > 0 && ghost;
  return [channel.measured, isMoved ? ghost.channels[index].simulated : empty, channel.simulated, channel.residual];
}

/** The library draws what the canvas has shown. */
async function settle(anew = false) {
  await (anew ? redraw() : refresh());
  clear();
}

/** Only the curves: axes and marks stay. */
function refresh() {
  const curves = shown.channels.flatMap((_, index) => curvesOf(index));
  return Plotly.restyle(plot, { x: curves.map((one) => one.x), y: curves.map((one) => one.y) },
    curves.map((_, index) => index));
}

async function redraw() {
  const experiment = bench.experiments[chosen];
  const traces = [];
  const form = layout({
    hovermode: "x unified", hoversubplots: "axis", dragmode: "zoom", uirevision: experiment.name,
    margin: { l: 70, r: 12, t: 30, b: 42 }, shapes: [], annotations: [],
  });
  const count = experiment.channels.length;
  const gap = 0.035;
  const high = (1 - 2 * gap * (count - 1)) / count;
  experiment.channels.forEach((channel, index) => {
    const top = 1 - index * (high + 2 * gap);
    const name = (k) => (k === 1 ? "" : String(k));
    const over = name(2 * index + 1);
    const rest = name(2 * index + 2);
    const [measured, old, model, residual] = curvesOf(index);
    const value = `%{y:.4~s}${channel.unit}`;
    const legend = { showlegend: index === 0 };
    traces.push(
      { x: measured.x, y: measured.y, yaxis: `y${over}`, name: "measured", legendgroup: "a", ...legend, mode: "lines", line: { color: colour("measured"), width: 1.3 }, hovertemplate: `measured ${channel.spoken} ${value}<extra></extra>` },
      { x: old.x, y: old.y, yaxis: `y${over}`, name: "fitted model", legendgroup: "b", ...legend, mode: "lines", line: { color: colour("ghost"), width: 1.3, dash: "dot" }, hovertemplate: `fitted ${value}<extra></extra>` },
      { x: model.x, y: model.y, yaxis: `y${over}`, name: "model", legendgroup: "c", ...legend, mode: "lines", line: { color: colour("model"), width: 1.5 }, hovertemplate: `model ${value}<extra></extra>` },
      { x: residual.x, y: residual.y, yaxis: `y${rest}`, name: "measured − model", legendgroup: "d", ...legend, mode: "lines", line: { color: colour("push"), width: 0.9 }, hovertemplate: `measured − model ${value}<extra></extra>` },
    );
    form[`yaxis${over}`] = axis(`${channel.spoken}<br>(${channel.unit})`, { domain: [top - high * 0.58, top], anchor: "x" });
    form[`yaxis${rest}`] = axis(`difference<br>(${channel.unit})`, { domain: [top - high, top - high * 0.58 - gap], anchor: "x" });
    form.shapes.push({
      type: "rect", xref: "paper", x0: 0, x1: 1, yref: `y${rest}`, y0: -channel.noise_std, y1: channel.noise_std,
      fillcolor: colour("band"), line: { width: 1, color: colour("ghost"), dash: "dot" }, layer: "above",
    });
  });
  form.xaxis = axis("time (s)", { anchor: `y${2 * count}`, exponentformat: "none", showspikes: true, spikemode: "across", spikethickness: 1, spikecolor: colour("quiet"), spikedash: "dot" });
  form.xaxis.range = [shown.view[0], shown.view[1]];
  for (const [from, to] of experiment.shading?.stretches ?? []) {
    form.shapes.push({ type: "rect", xref: "x", x0: from, x1: to, yref: "paper", y0: 0, y1: 1, fillcolor: colour("shade"), line: { width: 0 }, layer: "below" });
  }
  byId("shaded").textContent = experiment.shading ? `Shaded, where the model fails most: ${experiment.shading.text}.` : "";
  experiment.channels.forEach((channel, index) => lostMarks(channel, form[`yaxis${index ? 2 * index + 1 : ""}`].domain, form));
  for (const push of experiment.pushes) {
    form.shapes.push({ type: "line", xref: "x", x0: push.time_s, x1: push.time_s, yref: "paper", y0: 0, y1: 1, line: { color: colour("push"), width: 1, dash: "dash" } });
    form.annotations.push({ xref: "x", x: push.time_s, yref: "paper", y: 1, yanchor: "top", textangle: -90, showarrow: false, text: push.text, font: { size: 10, color: colour("push") }, bgcolor: colour("card") });
  }
  const lost = experiment.channels.filter((channel) => channel.lost)
    .map((channel) => `${channel.spoken}: ${channel.lost.samples} of ${experiment.samples} samples in ${channel.lost.runs} ${channel.lost.runs === 1 ? "place" : "places"}`);
  byId("lost").textContent = lost.length ? `Lost samples, marked on the time axis: ${lost.join("; ")}.` : "";
  plot.setAttribute("aria-label", `Measured and simulated ${experiment.channels.map((channel) => channel.spoken).join(", ")} of ${experiment.name}, and their difference`);
  plot.style.height = `${Math.max(440, 60 + 260 * count)}px`;
  drawing = true;
  await draw(plot, traces, form);
  drawing = false;
  if (!plot.dataset.listens) {
    plot.dataset.listens = "yes";
    plot.on("plotly_relayout", zoomed);
    plot.addEventListener("keydown", stepped);
  }
}

/** Samples that a channel lost: shaded in its plot, and a tick on the time axis that a single sample shows as well. */
function lostMarks(channel, [low, high], form) {
  const mark = (x0, x1, y0, y1, more) => form.shapes.push({ type: "rect", xref: "x", x0, x1, yref: "paper", y0, y1, ...more });
  for (const [from, to] of channel.lost?.marked ?? []) {
    mark(from, to, low, high, { fillcolor: colour("lost"), opacity: 0.25, line: { width: 0 }, layer: "below" });
    mark(from, to, 0, 0.012, { fillcolor: colour("lost"), line: { width: 2, color: colour("lost") }, layer: "above" });
  }
}

/** The keyboard's way over the time axis: arrows move by a quarter of the view, + and − halve and double it, 0 shows all. */
function stepped(event) {
  const [from, to] = plot._fullLayout.xaxis.range.map(Number);
  const [middle, width] = [(from + to) / 2, to - from];
  const around = (at, wide) => ({ "xaxis.range[0]": at - wide / 2, "xaxis.range[1]": at + wide / 2 });
  const next = {
    ArrowLeft: () => around(middle - width / 4, width), ArrowRight: () => around(middle + width / 4, width),
    "+": () => around(middle, width / 2), "=": () => around(middle, width / 2), "-": () => around(middle, width * 2), 0: () => ({ "xaxis.autorange": true }),
  }[event.key];
  if (!next || event.target !== plot || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  Plotly.relayout(plot, next());
}

function zoomed(change) {
  if (drawing) return;
  // A double click and the button "Reset axes" go back to the range of the first drawing: the whole log. The library
  // reports this range as a pair, and a dragged one by its ends.
  if (change["xaxis.autorange"] || "xaxis.range" in change) {
    view = { from_s: null, to_s: null };
    ghost = null;
    request(true);
  } else if ("xaxis.range[0]" in change) {
    const [from, to] = [change["xaxis.range[0]"], change["xaxis.range[1]"]];
    view = { from_s: Number(from), to_s: Number(to) };
    ghost = null;
    request(false);
  }
}
