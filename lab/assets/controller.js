// The emitted controller, its certificate and its proof, which fills claim by claim.
import { byId, el, table } from "./dom.js";
import { get } from "./server.js";

const panel = byId("panel-controller");
let begin = () => {};
let onError = () => {};
let design = null;
// The weights that were asked for last, of the bench that is open.
let asked = null;
let opened = null;
let file = "src/control.rs";
let statements = [];
let rows = [];
let places = null;
// Whether the panel is seen, and whether what it shows is of an earlier state.
let visible = false;
let isOld = false;

/** Asks for the controller of these weights; `preset` gives sensors and drive that the bench does not state. */
export function generate(wishes, preset = null) {
  asked = wishes;
  begin({ task: "generate", wishes, preset });
}

export function start(work, report) {
  begin = work;
  onError = report;
}

export async function setBench(state) {
  if (opened !== state.opened || JSON.stringify(design) !== JSON.stringify(state.design)) asked = null;
  opened = state.opened;
  design = state.design;
  isOld = true;
  if (visible || state.has_controller) await build();
}

export function shown() {
  visible = true;
  if (isOld) build().catch(onError);
}

export const hidden = () => { visible = false; };

const wishes = () => asked ?? design;

/** What the panel says before there is a controller: what is missing, and the click that emits one. */
function before(hardware) {
  const about = el("p", {}, "The controller is emitted as readable no_std Rust in fixed point. It reads raw sensor counts and writes the duty of the drive. With it comes a certificate; the proof reads the emitted files alone.");
  if (!hardware) return [about, el("button", { type: "button", class: "main", id: "generate", onclick: () => generate(wishes()) }, "Generate")];
  return [about, el("section", { class: "card", id: "hardware-missing" },
    el("h3", {}, "This bench does not state all of its sensors and its drive"),
    el("ul", { class: "small" }, hardware.missing.map((text) => el("li", {}, text))),
    el("p", {}, "For a controller of this bench, write them into ", el("code", {}, hardware.bench_path), " (",
      el("a", { href: "/help/files.md#hardware", target: "_blank", rel: "noopener" }, "every key, and the known parts"), "). The lab notices when the file is saved, and offers to read it."),
    el("p", {}, "To look at source and proof before that, take what is missing from the bench of the thesis. Such a controller must not drive your motor: it reads other sensors."),
    el("details", { open: true }, el("summary", { class: "small" }, "What is assumed then"), el("ul", { class: "small" }, hardware.assumed.map((text) => el("li", {}, text)))),
    el("button", { type: "button", class: "main", id: "generate-assumed", onclick: () => generate(wishes(), "thesis-bench") }, "Generate with the parts of the thesis bench"))];
}

async function build() {
  isOld = false;
  const found = await get("/api/controller");
  // Another state may have come meanwhile.
  if (isOld) return;
  places = null;
  if (!found?.files) {
    panel.replaceChildren(...before(found?.hardware));
    return;
  }
  statements = found.claims;
  rows = found.proof?.claims ?? [];
  const source = el("pre", { tabindex: 0, id: "source", role: "region", "aria-label": "Text of the file" });
  const show = () => { source.textContent = found.files.find((one) => one.path === file)?.text ?? ""; source.scrollTop = 0; };
  if (!found.files.some((one) => one.path === file)) file = found.files[0].path;
  const choice = el("select", { id: "emitted-file", "aria-label": "Emitted file", onchange: () => { file = choice.value; show(); } },
    found.files.map((one) => el("option", { selected: one.path === file }, one.path)));
  const certificate = el("button", { type: "button", onclick: () => { file = "certificate.json"; choice.value = file; show(); } }, "Certificate");
  show();
  places = { verdict: el("p", { id: "proof-verdict", role: "status" }), body: el("tbody", { id: "claims" }) };
  panel.replaceChildren(el("div", { class: "split" },
    el("div", {},
      el("div", { class: "row" },
        el("button", { type: "button", id: "prove", class: found.proof ? null : "main", onclick: () => { rows = []; fill(true); begin({ task: "prove" }); } }, found.proof ? "Prove again" : "Prove"),
        el("button", { type: "button", id: "write-controller", onclick: () => begin({ task: "write-controller" }) }, "Write into the bench folder"),
        el("button", { type: "button", id: "generate-again", onclick: () => generate(wishes(), found.assumed.length ? "thesis-bench" : null) }, "Generate again")),
      el("p", { class: "quiet small" }, `"Write into the bench folder" puts the files into ${found.folder}.`),
      el("ul", { class: "small" }, found.warnings.map((text) => el("li", { class: "bad" }, text)), found.assumed.map((text) => el("li", {}, `Taken from the thesis bench: ${text}`))),
      places.verdict, el("div", { class: "scroll" }, claimsTable())),
    el("div", {}, el("div", { class: "row" }, el("label", { for: "emitted-file" }, "Emitted file"), choice, certificate), source)));
  fill(false);
}

function claimsTable() {
  const whole = table(["claim", "result", "by", "time"], [], ["claim", "result", "by"]);
  whole.querySelector("tbody").replaceWith(places.body);
  return whole;
}

/** A row of the proof, as soon as it is settled. */
export function settled(claim) {
  if (!places) return;
  rows = rows.filter((row) => row.id !== claim.id || row.engine !== claim.engine);
  rows.push(claim);
  fill(true);
}

const TONES = { proved: "good", tested: "good", failed: "bad" };

/** All claims in their order; those that nothing has settled yet wait. */
function fill(running) {
  const lines = statements.flatMap((claim) => {
    const own = rows.filter((row) => row.id === claim.id);
    const about = el("details", {}, el("summary", {}, claim.id), el("p", { class: "small" }, claim.statement),
      el("p", { class: "small quiet" }, `For: ${claim.domain}.${claim.assumptions ? ` Assumed: ${claim.assumptions}.` : ""}`));
    if (!own.length) return [el("tr", { class: "quiet" }, el("td", { class: "wrap" }, about), el("td", { class: "left" }, running ? "…" : "not checked yet"), el("td", { class: "left" }, ""), el("td", {}, ""))];
    return own.map((row, index) => el("tr", { "data-claim": row.id, "data-result": row.result },
      el("td", { class: "wrap" }, index ? "" : about),
      el("td", { class: `left wrap ${TONES[row.result] ?? "quiet"}` }, row.result, row.cases ? ` (${row.cases.toLocaleString("en").replaceAll(",", "\u202f")} cases)` : "", row.result === "failed" || row.result.startsWith("not") ? el("div", { class: "small" }, row.why) : ""),
      el("td", { class: "left wrap" }, row.engine), el("td", {}, row.seconds < 0.05 ? "" : `${row.seconds.toFixed(1)} s`)));
  });
  places.body.replaceChildren(...lines);
  const failed = rows.filter((row) => row.result === "failed").map((row) => row.id);
  const settledIds = new Set(rows.filter((row) => row.result !== "not run").map((row) => row.id));
  const open = statements.map((claim) => claim.id).filter((id) => !settledIds.has(id));
  places.verdict.className = failed.length ? "bad" : open.length ? "" : "good";
  places.verdict.textContent = failed.length ? `Fails: ${[...new Set(failed)].join(", ")}. This controller must not be used.`
    : rows.length === 0 ? "" : running ? `${settledIds.size} of ${statements.length} claims settled …`
      : open.length ? `No claim fails, but ${open.length === 1 ? "one is" : `${open.length} are`} not settled: ${open.join(", ")}. The table says why.` : "Every claim that applies is settled, and none fails.";
}
