// Dropped CSV files become a bench: preview, proposal with its reasons, correction, and the folder on a click.
import { el } from "./dom.js";
import { get, post } from "./server.js";

let begin = () => {};
let complain = () => {};

export function start(work, report) {
  begin = work;
  complain = report;
}

/** The part of the opening page for files. */
export function panel() {
  const result = el("div", { id: "dropped" });
  const pick = el("input", { type: "file", multiple: true, accept: ".csv,.txt,.tsv,.dat,.log", id: "drop-files", onchange: () => take(pick.files, result) });
  const zone = el("div", {
    class: "card drop",
    ondragover: (event) => { event.preventDefault(); zone.classList.add("over"); },
    ondragleave: () => zone.classList.remove("over"),
    ondrop: (event) => { event.preventDefault(); zone.classList.remove("over"); take(event.dataTransfer.files, result); },
  }, el("label", { for: "drop-files" }, "Drop CSV files here, or choose them: "), pick);
  show(result).catch(complain);
  return el("div", {}, el("h2", {}, "Begin with your logs"), zone, result);
}

async function take(files, result) {
  complain(null);
  try {
    for (const file of files) {
      const response = await fetch(`/api/drop?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
      if (!response.ok) throw new Error((await response.json().catch(() => null))?.message ?? `${file.name}: too large, or refused`);
    }
  } catch (error) {
    complain(error);
  }
  await show(result);
}

async function show(result) {
  const found = await get("/api/drop");
  if (!found.files.length) {
    result.replaceChildren();
    return;
  }
  const files = found.files.map((file) => el("details", { open: found.files.length < 3 },
    el("summary", {}, `${file.name} (${file.bytes} bytes)`), el("pre", {}, file.lines.join("\n"))));
  const clear = el("button", { type: "button", onclick: async () => { await fetch("/api/drop", { method: "DELETE" }); await show(result); } }, "Forget these files");
  if (!found.proposal) {
    result.replaceChildren(...files, el("p", { class: "bad" }, found.failure), clear);
    return;
  }
  const proposal = found.proposal;
  const text = el("textarea", { id: "bench-text", rows: 22, spellcheck: "false", "aria-label": "bench.toml as proposed; correct it here" });
  text.value = proposal.text;
  const findings = el("div", { "aria-live": "polite" });
  const tell = (one) => findings.replaceChildren(
    one.failure ? el("p", { class: "bad" }, one.failure) : "",
    one.findings?.length ? el("ul", {}, one.findings.map((finding) => el("li", { class: finding.severity === "refuse" ? "bad" : null }, `${finding.sentence} ${finding.fix}`)))
      : one.failure ? "" : el("p", { class: "good" }, "The data agree with this description."));
  tell({ findings: proposal.findings, failure: proposal.open });
  let timer = 0;
  text.addEventListener("input", () => {
    clearTimeout(timer);
    timer = setTimeout(() => post("/api/drop/check", { text: text.value }).then(tell).catch(complain), 300);
  });
  const folder = el("input", { type: "text", size: 40, id: "new-folder", value: "my-bench", "aria-label": "New folder" });
  result.replaceChildren(...files,
    ...proposal.experiments.map((one) => el("div", { class: "card" }, el("h3", {}, `${one.name}: ${one.kind}`),
      el("ul", {}, one.reasons.map((reason) => el("li", { class: "small" }, reason)), one.questions.map((question) => el("li", { class: "bad small" }, question))))),
    el("h3", {}, "bench.toml"), el("p", { class: "quiet small" }, "Correct here what is wrong; masses, lengths and the torque constant go under [known]. It is checked as you type."),
    text, findings,
    el("div", { class: "row" }, el("label", { for: "new-folder" }, "New folder"), folder,
      el("button", { type: "button", class: "main", id: "make-bench", onclick: () => begin({ task: "create", folder: folder.value.trim(), text: text.value }) }, "Write and open"), clear));
}
