// The emitted controller, its certificate and its proof.
import { byId, el, table } from "./dom.js";
import { get } from "./server.js";

const panel = byId("panel-controller");
let begin = () => {};
let design = null;
let file = "src/control.rs";
let preset = false;

/** Asks for the controller of these weights. */
export const generate = (wishes) => begin({ task: "generate", wishes, preset: preset ? "thesis-bench" : null });

export function start(work) { begin = work; }

export async function setBench(state) {
  design = state.design;
  const found = state.has_controller ? await get("/api/controller") : null;
  if (!found?.files) {
    panel.replaceChildren(
      el("p", {}, "The controller is emitted as readable no_std Rust in fixed point, from raw sensor counts to the duty of the drive, with a certificate that is checked from the emitted files alone."),
      el("label", { class: "row small" },
        el("input", { type: "checkbox", id: "preset", checked: preset, onchange: (event) => { preset = event.target.checked; } }),
        "what the bench does not state of sensors and drive is that of the thesis bench"),
      el("button", { type: "button", class: "main", onclick: () => generate(design) }, "Generate"));
    return;
  }
  const source = el("pre", { tabindex: 0, "aria-label": "Text of the file" });
  const show = () => { source.textContent = found.files.find((one) => one.path === file)?.text ?? ""; };
  if (!found.files.some((one) => one.path === file)) file = found.files[0].path;
  const choice = el("select", { "aria-label": "Emitted file", onchange: () => { file = choice.value; show(); } },
    found.files.map((one) => el("option", { selected: one.path === file }, one.path)));
  show();
  panel.replaceChildren(
    el("div", { class: "row" },
      el("button", { type: "button", class: found.proof ? null : "main", onclick: () => begin({ task: "prove" }) }, "Prove"),
      el("button", { type: "button", onclick: () => begin({ task: "write-controller" }) }, "Write into the bench folder")),
    el("p", { class: "quiet small" }, found.folder),
    el("ul", { class: "small" }, found.warnings.map((text) => el("li", { class: "bad" }, text)), found.assumed.map((text) => el("li", {}, `taken from the thesis bench: ${text}`))),
    found.proof ? claims(found) : "", choice, source);
}

function claims(found) {
  const tone = { proved: "good", tested: "good", failed: "bad" };
  return el("div", {}, el("p", { class: found.passed ? "good" : "bad" }, found.passed ? "No claim fails." : "A claim fails: this controller must not be used."),
    el("div", { class: "scroll" }, table(["claim", "result", "engine"], found.proof.claims.map((claim) => el("tr", { title: claim.statement },
      el("td", { class: "wrap" }, claim.id), el("td", { class: `left ${tone[claim.result] ?? "quiet"}`, title: claim.why ?? claim.detail ?? "" }, claim.result), el("td", { class: "left wrap" }, claim.engine))))));
}
