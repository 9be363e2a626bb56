// Sliders for the parameters of the model. They change nothing but the picture until "Keep" or "Fit from here".
import { byId, el } from "./dom.js";
import { setChanges } from "./curves.js";

const STEPS = 2000;
const panel = byId("panel-sliders");
let sliders = [];
let values = new Map();
// Values before each move, for "one move back".
let past = [];
let fine = false;
let begin = () => {};
let askWhy = () => {};
let bench = null;
let rows = new Map();

/** `why` shows the panel that says why the model fails. */
export function start(work, why) {
  begin = work;
  askWhy = () => { why(); begin({ task: "diagnose" }); };
}

/** Moved sliders stay where they are as long as the model is the same. */
export function setBench(state) {
  const isSame = bench?.opened === state.opened && JSON.stringify(bench.sliders) === JSON.stringify(state.sliders);
  bench = state;
  sliders = state.sliders;
  if (!isSame) {
    values = new Map(sliders.map((one) => [one.name, one.value]));
    past = [];
  }
  build();
  if (moved().length) setChanges(moved());
}

const moved = () => sliders.filter((one) => values.get(one.name) !== one.value)
  .map((one) => [one.name, values.get(one.name)]);

function build() {
  rows = new Map();
  panel.replaceChildren(
    hint(),
    el("div", { class: "row" },
      el("button", { type: "button", id: "slider-back", title: "one move back", onclick: back }, "Back"),
      el("button", { type: "button", id: "slider-reset", onclick: reset }, "Reset"),
      el("button", { type: "button", id: "slider-fit", title: "fit the model, beginning with the values of the sliders", onclick: () => begin({ task: "fit", start: moved() }) }, "Fit from here"),
      el("button", { type: "button", id: "slider-keep", onclick: () => begin({ task: "keep", values: moved() }) }, "Keep"),
    ),
    el("label", { class: "row small" },
      el("input", { type: "checkbox", id: "slider-fine", checked: fine, onchange: (event) => { fine = event.target.checked; build(); } }),
      "fine: ten standard errors to either side"),
    el("p", { class: "quiet small" }, "The blue mark is the fitted value with its standard error. Moving a slider changes only the picture; Keep writes model.toml."),
    ...sliders.map(row),
  );
  update();
}

/** What a newcomer does next where the model fails and nobody has asked why. */
function hint() {
  const worst = bench.errors.reduce((most, row) => (row.over_noise > most.over_noise ? row : most), bench.errors[0]);
  if (bench.has_diagnosis || !worst?.fails) return "";
  return el("div", { class: "hint row", id: "hint" },
    el("span", { class: "grow small" }, `The model misses the ${worst.spoken} of ${worst.experiment} by ${worst.over_noise_text} times the noise of the sensor.`),
    el("button", { type: "button", class: "main", id: "ask-why", onclick: askWhy }, "What is missing?"));
}

function row(one) {
  const [least, most] = fine ? one.fine : one.coarse;
  const place = (value) => `${Math.min(100, Math.max(0, (100 * (value - least)) / (most - least)))}%`;
  const id = `slider-${one.name}`;
  const number = el("input", {
    type: "number", step: "any", "aria-label": `${one.name} in ${one.unit}`,
    onchange: (event) => { if (event.target.value !== "" && Number.isFinite(event.target.valueAsNumber)) { remember(); set(one, event.target.valueAsNumber); } },
  });
  const range = el("input", {
    type: "range", id, min: 0, max: STEPS, step: 1, "aria-describedby": `${id}-about`,
    onpointerdown: remember, onkeydown: (event) => { if (event.key.startsWith("Arrow") || event.key.startsWith("Page")) remember(); },
    oninput: (event) => set(one, least + ((most - least) * event.target.valueAsNumber) / STEPS),
    ondblclick: () => { remember(); set(one, one.value); },
  });
  const track = el("div", { class: "track" });
  if (one.std) {
    const band = el("div", { class: "error-band", title: "standard error" });
    band.style.left = place(one.value - one.std);
    band.style.width = `calc(${place(one.value + one.std)} - ${place(one.value - one.std)})`;
    track.append(band);
  }
  const fitted = el("div", { class: "fitted" });
  fitted.style.left = place(one.value);
  track.append(fitted, range);
  const element = el("div", { class: "slider" },
    el("div", { class: "row" }, el("label", { for: id }, one.name), el("span", { class: "row" }, number, el("span", { class: "unit small" }, one.unit))),
    track,
    el("p", { class: "quiet small", id: `${id}-about` }, `${one.meaning}: ${one.text} ${one.unit}`));
  rows.set(one.name, { element, number, range, least, most });
  return element;
}

function set(one, value) {
  values.set(one.name, one.whole ? Math.round(value) : value);
  update();
  setChanges(moved());
}

function remember() { past.push(new Map(values)); }

function back() {
  const before = past.pop();
  if (before) values = before;
  update();
  setChanges(moved());
}

function reset() {
  remember();
  values = new Map(sliders.map((one) => [one.name, one.value]));
  update();
  setChanges(moved());
}

function update() {
  for (const one of sliders) {
    const { element, number, range, least, most } = rows.get(one.name);
    const value = values.get(one.name);
    element.classList.toggle("moved", value !== one.value);
    if (document.activeElement !== number) number.value = Number(value.toPrecision(7));
    range.valueAsNumber = (STEPS * (value - least)) / (most - least);
    range.setAttribute("aria-valuetext", `${value.toPrecision(5)} ${one.unit}`);
  }
  const any = moved().length > 0;
  byId("slider-reset").disabled = !any;
  // Where nothing has moved, a fit finds what it has found before.
  byId("slider-fit").classList.toggle("main", any);
  byId("slider-keep").disabled = !any;
  byId("slider-back").disabled = past.length === 0;
}
