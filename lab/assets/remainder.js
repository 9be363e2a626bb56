// What no effect explains: the missing torque as a curve, a learned curve in its place, an effect of one's own.
import { el } from "./dom.js";
import { post } from "./server.js";
import { axis, colour, draw, layout } from "./plots.js";

/** What an editor begins with. */
const TEMPLATE = `role = "ROLE"          # the torque as it acts, in N m
torque = "a*z*exp(-z^2)"
z = "(COORDINATE - centre)/width"
fingerprint = "a magnet beside the path"

[parameters.a]
unit = "N m"
start = 1e-3

[parameters.centre]
unit = "UNIT"
start = CENTRE

[parameters.width]
unit = "UNIT"
start = WIDTH
bounds = [LEAST, MOST]
`;
/** What was typed for the bench that is open, and whether the editor is unfolded. */
let typed = { name: "mine", text: null, opened: null, isUnfolded: false };

/** The curve of the missing torque with its band, and what can be done with it. */
export function remainder(missing, begin, redraw, present, opened) {
  if (typed.opened !== opened) typed = { name: "mine", text: null, opened, isUnfolded: false };
  const spoken = missing.coordinate.replace("_", " ");
  const holder = el("div", { class: "plot", id: "missing-torque", role: "img", "aria-label": `missing torque over ${spoken}, with two standard errors` });
  redraw.push(() => {
    const x = missing.points.map((one) => one.at);
    const edge = (sign) => missing.points.map((one) => one.torque + sign * 2 * one.std);
    const side = (sign, more) => ({ x, y: edge(sign), mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false, ...more });
    return draw(holder, [side(-1, {}), side(1, { fill: "tonexty", fillcolor: colour("shade"), name: "±2 standard errors", showlegend: true }),
      { x, y: missing.points.map((one) => one.torque), mode: "lines", name: "missing torque", line: { color: colour("model"), width: 2 } }],
    layout({ xaxis: axis(`${spoken} (${missing.unit})`), yaxis: axis(`torque on the ${missing.acts_on}<br>(${missing.torque_unit})`) }));
  });
  const editor = ownEffect(missing, begin);
  return el("div", { class: "card", id: "remainder" }, el("h3", {}, "What no effect explains"),
    el("p", { class: "small" }, `The missing torque over ${spoken}, from ${missing.experiments.join(", ")}.`), holder,
    el("div", { class: "row" },
      el("button", { type: "button", id: "add-learned", onclick: () => begin({ task: "add-learned", coordinate: missing.coordinate }) },
        present ? "Learn the curve anew" : "Add as learned curve"),
      el("button", { type: "button", id: "write-own", "aria-expanded": String(typed.isUnfolded), onclick: (event) => {
        editor.hidden = !editor.hidden;
        typed.isUnfolded = !editor.hidden;
        event.currentTarget.setAttribute("aria-expanded", String(!editor.hidden));
      } }, "Write an effect of my own")),
    el("p", { class: "small quiet" }, "A learned curve follows what is missing and explains nothing: the verdict stays."), editor);
}

function begun(missing) {
  const at = missing.points.map((one) => one.at);
  const most = missing.points.reduce((best, one) => (Math.abs(one.torque) - 2 * one.std > Math.abs(best.torque) - 2 * best.std ? one : best));
  const span = at[at.length - 1] - at[0];
  const number = (value) => String(Number(value.toPrecision(2)));
  return TEMPLATE.replace("ROLE", missing.acts_on).replaceAll("COORDINATE", missing.coordinate).replaceAll("UNIT", missing.unit)
    .replace("CENTRE", number(most.at)).replace("WIDTH", number(span / 20)).replace("LEAST", number(span / 500)).replace("MOST", number(span));
}

function ownEffect(missing, begin) {
  typed.text ??= begun(missing);
  const says = el("p", { class: "small", id: "own-says", role: "status" });
  const keep = el("button", { type: "button", class: "main", id: "own-add", disabled: true, onclick: () => begin({ task: "write-effect", name: typed.name, text: typed.text }) }, "Write it and add it");
  const name = el("input", { type: "text", id: "own-name", value: typed.name, size: 16, oninput: () => { typed.name = name.value.trim(); check(); } });
  const text = el("textarea", { id: "own-text", rows: 18, spellcheck: "false", "aria-label": "Text of the effect", "aria-describedby": "own-says", oninput: () => { typed.text = text.value; check(); } });
  text.value = typed.text;
  let asked = 0;
  async function check() {
    asked += 1;
    const own = asked;
    const found = await post("/api/effect/check", { name: typed.name, text: typed.text }).catch((error) => ({ message: error.message }));
    // An answer to what was typed before says nothing.
    if (own !== asked) return;
    keep.disabled = Boolean(found.message);
    says.className = found.message ? "small bad" : "small good";
    const place = found.line ? `line ${found.line}${found.position ? `, column ${found.position}` : ""}: ` : "";
    says.textContent = found.message ? place + found.message : `It can be read; the fit finds ${found.parameters.join(", ")}.`;
    says.dataset.checked = String(own);
  }
  check();
  return el("div", { hidden: !typed.isUnfolded, id: "own-editor" },
    el("p", { class: "small quiet" }, "Written to effects/NAME.toml in the bench folder. Names: angle rate wheel_speed wheel_angle current pi; + − * / ^ sin cos tan exp ln sqrt tanh abs sign."),
    el("div", { class: "row" }, el("label", { for: "own-name" }, "Name"), name), text, says, el("div", { class: "row" }, keep));
}
