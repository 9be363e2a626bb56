// The controller: weights as sliders; poles, responses and margins as they move. Designs can be set aside beside.
import { byId, el } from "./dom.js";
import { generate } from "./controller.js";
import { post } from "./server.js";
import { axis, colour, draw, layout, onTheme } from "./plots.js";

const panel = byId("panel-design");
let begin = () => {};
let wishes = null;
let stored = null;
let result = null;
let aside = [];
let onError = () => {};
let busy = false;
let again = false;
let visible = false;
const parts = {};

/** What can be moved: where it stands, its label, and its track in decades around the stored value. */
const KNOBS = [
  [["state_weights", 0], "weight of the angle (1/rad²)", 2],
  [["state_weights", 1], "weight of the rate (s²/rad²)", 2],
  [["state_weights", 2], "weight of the wheel speed (s²/rad²)", 2],
  [["current_weight"], "weight of the current (1/A²)", 2],
  [["sample_time_s"], "sample time (s)", 1],
  [["current_limit_a"], "current limit (A)", 0.7],
];

export function start(work, report) {
  begin = work;
  onError = report;
  onTheme(() => { if (result) plots(); });
}

export function setBench(state) {
  stored = state.design;
  wishes = structuredClone(stored);
  aside = [];
  result = null;
  build();
  if (visible) compute();
}

export function shown() {
  visible = true;
  if (!result) compute(); else plots();
}

export const hidden = () => { visible = false; };

const read = (from, [key, index]) => (index === undefined ? from[key] : from[key][index]);
function write(into, [key, index], value) { if (index === undefined) into[key] = value; else into[key][index] = value; }

function build() {
  parts.numbers = el("dl", { id: "design-numbers" });
  parts.poles = el("div", { class: "plot", role: "img", "aria-label": "Poles of the open and of the closed loop" });
  parts.transient = el("div", { class: "plot tall", role: "img", "aria-label": "Response after being let go" });
  parts.disturbance = el("div", { class: "plot tall", role: "img", "aria-label": "Response to a push" });
  panel.replaceChildren(
    ...KNOBS.map(([path, label, decades], index) => knob(path, label, decades, index)),
    el("div", { class: "row" },
      el("button", { type: "button", onclick: () => { wishes = structuredClone(stored); build(); compute(); } }, "Reset"),
      el("button", { type: "button", onclick: () => { if (result) { aside.push(result); aside = aside.slice(-3); plots(); } } }, "Set aside to compare"),
      el("button", { type: "button", onclick: () => begin({ task: "keep-design", wishes }) }, "Keep"),
      el("button", { type: "button", class: "main", onclick: () => generate(wishes) }, "Generate")),
    parts.numbers, el("h3", {}, "Poles (1/s)"), parts.poles,
    el("h3", {}, "Let go off upright"), parts.transient, el("h3", {}, "One push"), parts.disturbance);
  if (result) plots();
}

function knob(path, label, decades, index) {
  const id = `knob-${index}`;
  const middle = read(stored, path);
  const steps = 400;
  const number = el("input", { type: "number", step: "any", "aria-label": label });
  const range = el("input", { type: "range", id, min: 0, max: steps });
  const show = () => {
    const value = read(wishes, path);
    if (document.activeElement !== number) number.value = Number(value.toPrecision(4));
    range.valueAsNumber = (steps / 2) * (1 + Math.log10(value / middle) / decades);
  };
  const set = (value) => { if (value > 0) { write(wishes, path, value); show(); compute(); } };
  range.addEventListener("input", () => set(Number((middle * 10 ** (decades * ((2 * range.valueAsNumber) / steps - 1))).toPrecision(4))));
  number.addEventListener("change", () => set(number.valueAsNumber));
  show();
  return el("div", { class: "slider" }, el("div", { class: "row" }, el("label", { for: id }, label), number), el("div", { class: "track" }, range));
}

async function compute() {
  if (busy) { again = true; return; }
  busy = true;
  try {
    do {
      again = false;
      result = await post("/api/design", wishes);
      plots();
    } while (again);
    onError(null);
  } catch (error) {
    onError(error);
  } finally {
    busy = false;
  }
}

function plots() {
  parts.numbers.replaceChildren(...result.numbers.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]));
  const poles = (list, name, tone, symbol) => ({ x: list.map((p) => p[0]), y: list.map((p) => p[1]), mode: "markers", name, marker: { color: colour(tone), size: 9, symbol } });
  draw(parts.poles, [
    poles(result.report.open_loop_poles, "without controller", "measured", "x"),
    poles(result.report.closed_loop_poles_per_s, "controlled", "model", "circle"),
    ...aside.map((one, index) => poles(one.report.closed_loop_poles_per_s, `aside ${index + 1}`, "ghost", "circle-open")),
  ], layout({ xaxis: axis("real part"), yaxis: axis("imaginary part") }));
  result.responses.forEach((run, index) => {
    const into = parts[run.scenario];
    if (!into) return;
    const lines = (of, name, tone, dash) => [["angle_rad", "y"], ["wheel_speed_rad_s", "y2"], ["current_a", "y3"]].map(([key, yaxis], row) => ({
      x: of[key][0], y: of[key][1], yaxis, name, legendgroup: name, showlegend: row === 0, mode: "lines", line: { color: colour(tone), width: 1.4, dash },
    }));
    draw(into, [...lines(run, run.fell ? "falls" : "now", "model", "solid"), ...aside.flatMap((one, k) => lines(one.responses[index], `aside ${k + 1}`, "ghost", ["dot", "dash", "dashdot"][k % 3]))],
      layout({
        xaxis: axis("time (s)", { anchor: "y3", exponentformat: "none" }),
        yaxis: axis("angle (rad)", { domain: [0.7, 1] }), yaxis2: axis("wheel (rad/s)", { domain: [0.36, 0.64] }), yaxis3: axis("current (A)", { domain: [0, 0.3] }),
      }));
  });
}
