// Puts the panels together: the state from the server, the work under way, the tabs.
import { byId, el } from "./dom.js";
import { SILENT, callOff, download, get, listen, post } from "./server.js";
import * as controller from "./controller.js";
import * as curves from "./curves.js";
import * as design from "./design.js";
import * as opening from "./open.js";
import * as sliders from "./sliders.js";
import * as why from "./why.js";

const TABS = ["sliders", "why", "design", "controller"];
// Panels that need the room of the curves.
const WIDE = ["design", "controller"];
const panels = { sliders, why, design, controller };
let folder = null;
let choosing = false;
let shownTab = null;
// The number of the work that this page has begun; "asked" until the server has said it.
let own = null;
// Files of the bench that another program has changed.
let outside = [];
// Why the model could not be written, if so.
let unsaved = null;
let isGone = false;

function complain(error) {
  // That nobody answers stands in the notice as long as it is so.
  if (error?.message === SILENT && isGone) return;
  byId("message").hidden = !error;
  byId("message-text").textContent = error ? error.message : "";
}

function working(running) {
  byId("work").hidden = !running;
  if (running) byId("work-text").textContent = `${running.name} … ${running.says ?? ""}`;
  document.body.dataset.working = running ? "yes" : "no";
}

async function begin(task) {
  complain(null);
  own = "asked";
  try {
    own = (await post("/api/work", task)).number;
  } catch (error) {
    own = null;
    complain(error);
  }
}

/** Panels are built anew after work: who works with the keyboard goes on from the same place, or from its tab. */
function focusKeeper() {
  const place = document.activeElement;
  const ids = [place?.id, place?.closest("[role=tabpanel]")?.getAttribute("aria-labelledby")].filter(Boolean);
  return () => {
    for (const id of ids) if (document.activeElement === document.body) byId(id)?.focus({ preventScroll: true });
  };
}

async function refresh() {
  const keepFocus = focusKeeper();
  const state = await get("/api/state");
  working(state.running);
  if (state.failure) complain(new Error(state.failure));
  const bench = state.bench;
  const opens = !bench || choosing;
  byId("opening").hidden = !opens;
  byId("lab").hidden = opens;
  byId("report").hidden = opens;
  byId("open-other").hidden = !bench;
  byId("open-other").textContent = choosing ? "Back" : "Open another bench";
  byId("undo").hidden = opens;
  byId("undo").disabled = !bench || bench.undo === 0;
  byId("bench-name").textContent = bench ? `${bench.name} · ${bench.folder}` : "";
  document.title = bench ? `${bench.name} · flywheel lab` : "flywheel lab";
  if (opens) {
    // What was typed there stays.
    if (!opening.isShown()) await opening.show();
    return;
  }
  opening.hide();
  outside = state.changed_outside;
  unsaved = bench.unsaved;
  notice();
  remarks(bench);
  const fresh = bench.folder !== folder;
  folder = bench.folder;
  // Where the list of files was scrolled to says nothing here.
  if (fresh) scrollTo(0, 0);
  if (!shownTab) tab("sliders");
  curves.setBench(bench, fresh);
  sliders.setBench(bench);
  design.setBench(bench);
  await Promise.all([why.setBench(bench), controller.setBench(bench)]);
  keepFocus();
  if (fresh && document.activeElement === document.body) byId(`tab-${shownTab}`).focus({ preventScroll: true });
  document.body.dataset.ready = String(Number(document.body.dataset.ready ?? 0) + 1);
}

/** What holds as long as it is so, and no click can close. */
function notice() {
  const line = byId("notice");
  line.hidden = !isGone && !unsaved && !outside.length;
  if (isGone) {
    line.replaceChildren(el("span", { class: "grow", id: "gone" }, SILENT));
  } else if (outside.length) {
    const anew = "What the lab has found since it was opened (diagnosis, staircase, undo) begins anew with it.";
    line.replaceChildren(el("span", { class: "grow" }, `${outside.join(", ")} changed outside of the lab. ${anew}`),
      el("button", { type: "button", id: "read-anew", onclick: () => begin({ task: "open", path: folder }) }, "Read the folder anew"));
  } else if (unsaved) {
    line.replaceChildren(el("span", { class: "grow" }, `The model could not be written: ${unsaved}. Everything else works; what the lab finds is lost when it ends.`));
  }
}

function remarks(bench) {
  const lines = [...bench.statements, ...bench.notes.map((one) => (one.experiment ? `${one.experiment}: ${one.note}` : one.note))];
  const places = bench.places.slice(0, 6).map((one) => `${one.experiment}/${one.channel}, ${one.residual}: ${one.text}, ${one.share} of the error`);
  const list = (heading, texts) => (texts.length ? [el("h2", {}, heading), el("ul", { class: "small" }, texts.map((text) => el("li", {}, text)))] : []);
  byId("remarks").replaceChildren(...list("Where the model fails", places), ...list("What the logs show, and what they do not", lines));
}

function tab(name) {
  // Who works with the keyboard would be at the top of the page again, where the focus is in a panel that is hidden now.
  const leaves = document.activeElement?.closest("[role=tabpanel]");
  if (leaves && leaves.id !== `panel-${name}`) byId(`tab-${name}`).focus({ preventScroll: true });
  for (const one of TABS) {
    const on = one === name;
    const knob = byId(`tab-${one}`);
    knob.setAttribute("aria-selected", String(on));
    knob.tabIndex = on ? 0 : -1;
    byId(`panel-${one}`).hidden = !on;
    if (!on) panels[one].hidden?.();
  }
  shownTab = name;
  byId("lab").classList.toggle("wide", WIDE.includes(name));
  if (!WIDE.includes(name)) curves.resize();
  panels[name].shown?.();
}

TABS.forEach((name, index) => {
  byId(`tab-${name}`).addEventListener("click", () => tab(name));
  byId(`tab-${name}`).addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const next = TABS[(index + step + TABS.length) % TABS.length];
    tab(next);
    byId(`tab-${next}`).focus();
  });
});
byId("undo").addEventListener("click", () => begin({ task: "undo" }));
byId("report").addEventListener("click", report);
byId("cancel").addEventListener("click", callOff);
byId("message-close").addEventListener("click", () => complain(null));
byId("open-other").addEventListener("click", () => choose(!choosing));

/** Shows where a bench is opened and where logs are dropped, or goes back to the bench. */
function choose(wanted) {
  choosing = wanted;
  complain(null);
  refresh().catch(complain);
}

/** The report takes seconds to make; then the browser keeps it as a file. */
async function report() {
  const button = byId("report");
  complain(null);
  button.disabled = true;
  button.textContent = "Writing the report …";
  try {
    const address = URL.createObjectURL(await download("/api/report"));
    el("a", { href: address, download: "report.html" }).click();
    button.textContent = "Report: saved";
    setTimeout(() => { URL.revokeObjectURL(address); button.textContent = "Report"; }, 4000);
  } catch (error) {
    button.textContent = "Report";
    complain(error);
  } finally {
    button.disabled = false;
  }
}

function told(event) {
  if (event.event === "says" || event.event === "begun") working(event);
  else if (event.event === "claim") controller.settled(event.claim);
  else if (event.event === "ended") {
    working(null);
    choosing = choosing && Boolean(event.failure);
    if (event.failure && !event.cancelled) complain(new Error(event.failure));
    const isOwn = own === "asked" || own === event.number;
    refresh().then(() => { if (isOwn && event.name.startsWith("Generating")) tab("controller"); }).catch(complain);
  } else if (event.event === "outside") {
    outside = event.files;
    notice();
  } else if (event.event === "connected" || event.event === "lagged") {
    if (isGone) complain(null);
    isGone = false;
    refresh().catch(complain);
  } else if (event.event === "gone") {
    isGone = true;
    working(null);
    notice();
  }
}

// What sticks below the bars is told their height.
new ResizeObserver(() => document.documentElement.style.setProperty("--bars", `${byId("bars").offsetHeight}px`)).observe(byId("bars"));

for (const part of [opening, controller]) part.start(begin, complain);
sliders.start(begin, () => tab("why"));
curves.start(complain);
design.start(begin, complain);
why.start(begin, () => tab("design"), () => choose(true)).then(() => listen(told)).catch(complain);
