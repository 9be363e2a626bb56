// The controller: wishes as sliders; what its loop does, as they move. Designs can be set aside and stay beside.
import { byId, el, table } from "./dom.js";
import { generate } from "./controller.js";
import { post } from "./server.js";
import { plots, redraw, show } from "./design-plots.js";
import { onTheme } from "./plots.js";

const panel = byId("panel-design");
const MOST_ASIDE = 4;
let begin = () => {};
let onError = () => {};
let stored = null;
// The model whose designs are shown, as text.
let model = null;
// What the sliders say: wishes as model.toml has them, the excursions that they allow, and a delay.
let wishes = null;
let excursions = null;
let delay_s = 0;
let byExcursions = false;
let result = null;
let aside = [];
let busy = false;
let again = false;
let visible = false;
// Whether the message that is shown is of these weights.
let failed = false;
let refreshKnobs = [];
let parts = {};

const STEPS = 400;

/** Where a value stands, its label, and half of its track in decades around where it was when the bench was opened. */
const WEIGHTS = [
  { list: "weights", key: 0, label: "weight of the angle (1/rad²)", decades: 2 },
  { list: "weights", key: 1, label: "weight of the rate (s²/rad²)", decades: 2 },
  { list: "weights", key: 2, label: "weight of the wheel speed (s²/rad²)", decades: 2 },
  { list: "weights", key: 3, label: "weight of the current (1/A²)", decades: 2 },
];
const EXCURSIONS = [
  { list: "excursions", key: 0, label: "allowed angle (rad)", decades: 1 },
  { list: "excursions", key: 1, label: "allowed rate (rad/s)", decades: 1 },
  { list: "excursions", key: 2, label: "allowed wheel speed (rad/s)", decades: 1 },
  { list: "excursions", key: 3, label: "allowed current (A)", decades: 1 },
];
const OTHERS = [
  { list: "wishes", key: "sample_time_s", label: "sample time (s)", decades: 1 },
  { list: "wishes", key: "current_limit_a", label: "current limit (A)", decades: 0.7 },
];

export function start(work, report) {
  begin = work;
  onError = report;
  onTheme(() => { if (result) redraw(); });
}

/** Moved weights and the designs aside stay as long as the model is the same. */
export function setBench(state) {
  const of = JSON.stringify([state.opened, state.effects, state.sliders]);
  const isSame = of === model;
  const hasKept = JSON.stringify(state.design) === JSON.stringify(wishes);
  const wasStored = JSON.stringify(state.design) === JSON.stringify(stored);
  model = of;
  stored = state.design;
  if (isSame && (hasKept || wasStored)) return;
  wishes = structuredClone(stored);
  if (!isSame) aside = [];
  delay_s = 0;
  result = null;
  panel.replaceChildren(el("p", { class: "quiet" }, "computing the design …"));
  if (visible) compute(true);
}

export function shown() {
  visible = true;
  if (result) redraw(); else if (stored) compute(true);
}

export const hidden = () => { visible = false; };

function read({ list, key }) {
  if (list === "excursions") return excursions?.[key] ?? null;
  if (list === "weights") return key === 3 ? wishes.current_weight : wishes.state_weights[key];
  return wishes[key];
}

function write({ list, key }, value) {
  if (list === "excursions") excursions[key] = value;
  else if (list === "weights") { if (key === 3) wishes.current_weight = value; else wishes.state_weights[key] = value; } else wishes[key] = value;
}

function build() {
  refreshKnobs = [];
  const wanted = byExcursions ? EXCURSIONS : WEIGHTS;
  const way = (value, text) => el("label", { class: "small" }, el("input", {
    type: "radio", name: "design-way", checked: byExcursions === value, id: value ? "by-excursions" : "by-weights",
    onchange: () => { byExcursions = value; build(); },
  }), ` ${text}`);
  parts = { numbers: el("div", { id: "design-numbers", class: "scroll" }), aside: el("div", { class: "row small" }), plots: el("div", { class: "plots" }) };
  panel.replaceChildren(el("div", { class: "desk" },
    el("div", { class: "knobs" },
      el("fieldset", { class: "row" }, el("legend", { class: "quiet small" }, "How the quadratic cost is stated"), way(false, "weights"), way(true, "allowed excursions (Bryson's rule)")),
      ...[...wanted, ...OTHERS].map(knob), delayKnob(),
      el("div", { class: "row" },
        el("button", { type: "button", id: "design-reset", onclick: () => { wishes = structuredClone(stored); delay_s = 0; compute(true); } }, "Reset"),
        el("button", { type: "button", id: "design-aside", onclick: setAside }, "Set aside to compare"),
        el("button", { type: "button", id: "design-keep", onclick: () => begin({ task: "keep-design", wishes }) }, "Keep"),
        el("button", { type: "button", class: "main", id: "design-generate", onclick: () => generate(wishes) }, "Generate")),
      el("div", { class: "row small" }, "Export parameters and matrices: ",
        el("a", { class: "button", href: "/api/export/python" }, "Python (NumPy)"), el("a", { class: "button", href: "/api/export/matlab" }, "MATLAB")),
      el("p", { class: "quiet small" }, "Keep writes these weights to [design] of model.toml. The exports contain the design that was kept last."),
      parts.aside),
    el("div", { class: "results" }, parts.numbers, parts.plots)));
  plots(parts.plots);
  tell();
}

function knob(place, index) {
  const id = `knob-${place.list === "wishes" ? place.key : `${place.list}-${index}`}`;
  const middle = read(place) || 1;
  const number = el("input", { type: "number", step: "any", "aria-label": place.label });
  const range = el("input", { type: "range", id, min: 0, max: STEPS });
  const refresh = () => {
    const value = read(place);
    if (document.activeElement !== number) number.value = value === null ? "" : Number(value.toPrecision(4));
    range.valueAsNumber = (STEPS / 2) * (1 + Math.log10((value || 1e-300) / middle) / place.decades);
  };
  const set = (value) => { if (value > 0) { write(place, value); refresh(); compute(false); } };
  range.addEventListener("input", () => set(Number((middle * 10 ** (place.decades * ((2 * range.valueAsNumber) / STEPS - 1))).toPrecision(4))));
  number.addEventListener("change", () => set(number.valueAsNumber));
  refreshKnobs.push(refresh);
  refresh();
  return el("div", { class: "slider" }, el("div", { class: "row" }, el("label", { for: id }, place.label), number), el("div", { class: "track" }, range));
}

function delayKnob() {
  const label = "delay of the current (ms)";
  const number = el("input", { type: "number", step: "any", min: 0, "aria-label": label });
  const range = el("input", { type: "range", id: "knob-delay", min: 0, max: 20, step: 0.1 });
  const refresh = () => {
    if (document.activeElement !== number) number.value = Number((1e3 * delay_s).toPrecision(4));
    range.valueAsNumber = 1e3 * delay_s;
  };
  const set = (value) => { if (value >= 0) { delay_s = value / 1e3; refresh(); compute(false); } };
  range.addEventListener("input", () => set(range.valueAsNumber));
  number.addEventListener("change", () => set(number.valueAsNumber));
  refreshKnobs.push(refresh);
  refresh();
  return el("div", { class: "slider" }, el("div", { class: "row" }, el("label", { for: "knob-delay" }, label), number), el("div", { class: "track" }, range));
}

function setAside() {
  if (!result) return;
  const name = String.fromCharCode(65 + (aside.length ? (aside.at(-1).name.charCodeAt(0) - 64) % 26 : 0));
  aside = [...aside, { name, result, wishes: structuredClone(wishes) }].slice(-MOST_ASIDE);
  tell();
}

/** `anew`: from the stored wishes, with sliders around them; else what the sliders say. */
async function compute(anew) {
  if (busy) { again = anew ? "anew" : again || "moved"; return; }
  busy = true;
  try {
    let fresh = anew;
    do {
      again = false;
      const asked = { wishes, delay_s };
      if (byExcursions && !fresh && excursions.every((one) => one !== null)) asked.excursions = excursions;
      const found = await post("/api/design", asked);
      if (again === "anew") { fresh = true; continue; }
      result = found;
      const allowed = found.expectations.excursions;
      if (!again) {
        wishes = { ...wishes, ...found.wishes };
        excursions = [allowed.angle_rad, allowed.rate_rad_s, allowed.wheel_speed_rad_s, allowed.current_a];
      }
      if (fresh || !parts.numbers) build(); else { if (!again) refreshKnobs.forEach((refresh) => refresh()); tell(); }
      fresh = false;
    } while (again);
    // Only its own complaint: that of a failed work stays until it is read.
    if (failed) onError(null);
    failed = false;
  } catch (error) {
    // Weights that give no controller can be moved all the same.
    if (!parts.numbers?.isConnected) build();
    failed = true;
    onError(error);
  } finally {
    busy = false;
  }
  document.body.dataset.designed = String(Number(document.body.dataset.designed ?? 0) + 1);
}

/** Numbers and plots of the design, and of those aside. */
function tell() {
  if (!result) return;
  const all = [{ name: "now", result }, ...aside];
  const names = [...new Set(all.flatMap((one) => one.result.numbers.map(([name]) => name)))];
  const value = (one, name) => one.result.numbers.find(([own]) => own === name)?.[1] ?? "–";
  parts.numbers.replaceChildren(table(["of the loop", ...all.map((one) => one.name)],
    names.map((name) => el("tr", {}, el("td", { class: "wrap quiet" }, name), all.map((one) => el("td", { class: "wrap" }, value(one, name)))))));
  parts.aside.replaceChildren(...(aside.length ? ["Aside: ", ...aside.map((one) => el("span", { class: "row" },
    el("button", { type: "button", title: "move the sliders to this design", onclick: () => { wishes = structuredClone(one.wishes); compute(true); } }, `Take ${one.name}`),
    el("button", { type: "button", "aria-label": `Drop ${one.name}`, onclick: () => { aside = aside.filter((other) => other !== one); tell(); } }, "×")))] : []));
  show(all);
}
