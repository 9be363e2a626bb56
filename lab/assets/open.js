// Where a bench is chosen.
import { byId, el } from "./dom.js";
import { get } from "./server.js";
import * as drop from "./drop.js";

const page = byId("opening");
let begin = () => {};

export function start(work, report) {
  begin = work;
  drop.start(work, report);
}

let shown = false;
export const isShown = () => shown;

export function hide() {
  shown = false;
  page.replaceChildren();
}

export async function show() {
  shown = true;
  const path = el("input", { type: "text", id: "bench-path", size: 40, placeholder: "/home/me/bench", spellcheck: "false", autocomplete: "off" });
  const anew = el("input", { type: "checkbox" });
  const list = el("ul", {}, el("li", { class: "quiet" }, "looking …"));
  page.replaceChildren(
    el("h2", {}, "Open a bench"),
    el("p", {}, "A bench is a folder with a bench.toml and CSV logs. The lab compares the model of the bench with its measurements, shows where the model fails and which effect it lacks, and designs the controller. All results are kept in that folder."),
    el("form", { class: "row", onsubmit: (event) => { event.preventDefault(); if (path.value.trim()) begin({ task: "open", path: path.value.trim(), refit: anew.checked }); } },
      el("label", { for: "bench-path" }, "Folder"), path, el("button", { class: "main" }, "Open"),
      el("label", { class: "small" }, anew, " fit its model anew")),
    el("h2", {}, "Benches in this folder"), list,
    drop.panel(),
    el("h2", {}, "Or look around first"),
    el("p", {}, "The demonstration bench is simulated; its pivot has an effect that the base model lacks. Its files are written to out/lab-demo."),
    el("button", { type: "button", id: "open-demonstration", onclick: () => begin({ task: "open-demonstration" }) }, "Open the demonstration bench"));
  const found = await get("/api/benches");
  list.replaceChildren(...(found.length ? found.map((one) => el("li", {}, el("button", { type: "button", onclick: () => begin({ task: "open", path: one }) }, one)))
    : [el("li", { class: "quiet" }, "no folder with a bench.toml at or below the working directory")]));
}
