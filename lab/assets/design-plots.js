// The plots of a design and of those beside it. What is out of sight is drawn when it is scrolled into sight.
import { el } from "./dom.js";
import { axis, colour, draw, layout } from "./plots.js";

const TONES = ["model", "ghost", "push", "good", "measured"];
let holders = [];
let designs = [];
let watcher = null;

/** Makes the places of all plots in an element. */
export function plots(into) {
  watcher?.disconnect();
  watcher = new IntersectionObserver((entries) => entries.forEach((entry) => {
    const holder = holders.find((one) => one.element === entry.target);
    holder.seen = entry.isIntersecting;
    if (holder.seen && holder.old) paint(holder);
  }));
  holders = FIGURES.map((figure) => {
    const element = el("div", { class: `plot ${figure.size ?? ""}`, role: "img", "aria-label": figure.title });
    const about = el("p", { class: "quiet small" });
    into.append(el("div", { class: "figure" }, el("h2", {}, figure.title), about, element));
    watcher.observe(element);
    return { element, about, figure, seen: false, old: true };
  });
}

/** Shows these designs: the first is the one that the sliders move. */
export function show(all) {
  designs = all;
  redraw();
}

export function redraw() {
  for (const holder of holders) {
    holder.old = true;
    if (holder.seen) paint(holder);
  }
}

function paint(holder) {
  if (!designs.length) return;
  holder.old = false;
  const { traces, form, about } = holder.figure.of(designs);
  holder.about.textContent = about ?? "";
  draw(holder.element, traces, layout({ margin: { l: 62, r: 12, t: 22, b: 40 }, ...form, legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom", font: { size: 11 } }, showlegend: designs.length > 1 || Boolean(holder.figure.legend) }), { displayModeBar: false });
}

const tone = (index) => colour(TONES[index % TONES.length]);
const dash = (index) => (index === 0 ? "solid" : ["dot", "dash", "dashdot", "longdash"][(index - 1) % 4]);

/** A colour of the page, nearly transparent. */
function pale(text) {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
  return `rgba(${r}, ${g}, ${b}, 0.18)`;
}

const ROWS = [["angle_rad", "angle (rad)", "y", [0.7, 1]], ["wheel_speed_rad_s", "wheel (rad/s)", "y2", [0.35, 0.65]], ["current_a", "current (A)", "y3", [0, 0.3]]];
const stacked = (end) => ({
  xaxis: axis("time (s)", { anchor: "y3", exponentformat: "none", range: end ? [0, end] : undefined }),
  ...Object.fromEntries(ROWS.map(([, title, name, domain]) => [name.replace("y", "yaxis"), axis(title, { domain, nticks: 4 })])),
});

function answers(key) {
  return (all) => {
    const found = all.map((one, index) => ({ ...one, index, answer: one.result[key] })).filter((one) => one.answer);
    const traces = found.flatMap(({ name, answer, index }) => ROWS.flatMap(([part, , yaxis], row) => {
      const { y, low, high } = answer[part];
      const line = { x: answer.time_s, y, yaxis, name, legendgroup: name, showlegend: row === 0, mode: "lines", line: { color: tone(index), width: 1.6, dash: dash(index) } };
      if (!low.length) return [line];
      const edge = { x: answer.time_s, yaxis, legendgroup: name, showlegend: false, mode: "lines", line: { width: 0 }, hoverinfo: "skip" };
      return [{ ...edge, y: low }, { ...edge, y: high, fill: "tonexty", fillcolor: pale(tone(index)) }, line];
    }));
    const banded = found.some(({ answer }) => answer.angle_rad.low.length);
    const first = found[0]?.answer;
    return { traces, form: stacked(), about: first ? `${first.about}${banded ? "; bands: 95 % of the parameter sets within their errors" : ""}` : "no stable loop with this delay" };
  };
}

function runs(scenario) {
  return (all) => ({
    traces: all.flatMap(({ name, result }, index) => {
      const run = result.responses.find((one) => one.scenario === scenario);
      if (!run) return [];
      return ROWS.map(([part, , yaxis], row) => ({
        x: run[part][0], y: run[part][1], yaxis, name: run.fell ? `${name} (falls)` : name, legendgroup: name, showlegend: row === 0, mode: "lines", line: { color: tone(index), width: 1.3, dash: dash(index) },
      }));
    }),
    form: stacked(),
    about: `${all[0].result.responses.find((one) => one.scenario === scenario)?.about ?? ""}; nonlinear, with sensor noise and the current limit`,
  });
}

function poles(all) {
  const marks = (list, name, mark) => ({ x: list.map((p) => p[0]), y: list.map((p) => p[1]), mode: "markers", name, marker: mark });
  return {
    traces: [
      marks(all[0].result.report.open_loop_poles, "without controller", { color: colour("measured"), size: 10, symbol: "x" }),
      ...all.map(({ name, result }, index) => marks(result.report.closed_loop_poles_per_s, index ? name : "controlled", { color: tone(index), size: 10, symbol: index ? "circle-open" : "circle", line: { width: 2, color: tone(index) } })),
    ],
    form: { xaxis: axis("real part (1/s)"), yaxis: axis("imaginary part (1/s)"), shapes: [{ type: "line", x0: 0, x1: 0, yref: "paper", y0: 0, y1: 1, line: { color: colour("bad"), width: 1, dash: "dash" } }] },
    about: "stable left of the dashed line",
  };
}

function bode(all) {
  return {
    traces: all.flatMap(({ name, result }, index) => {
      const { frequency_rad_s: x, size, phase_deg: phase } = result.frequencies;
      const line = { x, name, legendgroup: name, mode: "lines", line: { color: tone(index), width: 1.6, dash: dash(index) } };
      return [{ ...line, y: size }, { ...line, y: phase, yaxis: "y2", showlegend: false }];
    }),
    form: {
      xaxis: axis("frequency (rad/s)", { type: "log", anchor: "y2", exponentformat: "power", dtick: 1 }),
      yaxis: axis("magnitude", { type: "log", domain: [0.54, 1], exponentformat: "power", dtick: 1 }), yaxis2: axis("phase (°)", { domain: [0, 0.46], exponentformat: "none" }),
      shapes: [["y", 1], ["y2", -180]].map(([yref, at]) => ({ type: "line", xref: "paper", x0: 0, x1: 1, yref, y0: at, y1: at, line: { color: colour("good"), width: 1, dash: "dash" } })),
    },
    about: "the margins are read where the curves cross the dashed lines",
  };
}

function nyquist(all) {
  const circle = (middle, radius, line) => ({ type: "circle", xref: "x", yref: "y", x0: middle - radius, x1: middle + radius, y0: -radius, y1: radius, line });
  const touched = all.map(({ result }, index) => [result.expectations.margins?.modulus_margin, index]).filter(([radius]) => radius);
  return {
    traces: [
      ...all.map(({ name, result }, index) => ({ x: result.frequencies.re, y: result.frequencies.im, name, mode: "lines", line: { color: tone(index), width: 1.8, dash: dash(index) } })),
      { x: [-1], y: [0], name: "−1", mode: "markers", showlegend: false, marker: { color: colour("bad"), size: 11, symbol: "x" } },
    ],
    form: {
      xaxis: axis("real part", { range: [-4, 1], exponentformat: "none" }), yaxis: axis("imaginary part", { range: [-2.2, 2.2], scaleanchor: "x", exponentformat: "none" }),
      shapes: [circle(0, 1, { color: colour("quiet"), width: 1, dash: "dot" }), ...touched.map(([radius, index]) => circle(-1, radius, { color: tone(index), width: 1, dash: "dash" }))],
    },
    about: "the radius of the dashed circle is the smallest distance of the open loop from −1",
  };
}

const FIGURES = [
  { title: "Response to a torque step", size: "tall", of: answers("step") },
  { title: "Response to a push", size: "tall", of: answers("push") },
  { title: "Bode diagram of the open loop", size: "tall", of: bode },
  { title: "Nyquist diagram of the open loop", size: "tall", of: nyquist },
  { title: "Poles", legend: true, size: "tall", of: poles },
  { title: "Released beside upright", size: "tall", of: runs("transient") },
];
