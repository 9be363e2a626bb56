// The error of every series, as it is while sliders move; a row chooses its experiment.
import { byId, el, table } from "./dom.js";

// What the table shows: cells are changed where they stand, because a new table costs a frame.
let shown = null;

const nameOf = (row) => `${row.experiment}/${row.channel}`;

/**
 * `rows` from the server, of all series or of some: the others keep what they say, and are marked as out of date.
 * `fitted` are those of the model without moved sliders, or null.
 */
export function showErrors(rows, fitted, chosen, choose) {
  const all = fitted ?? rows;
  const shape = JSON.stringify([Boolean(fitted), all.map(nameOf)]);
  if (shown?.shape !== shape) build(shape, all, Boolean(fitted), choose);
  const now = new Map(rows.map((row) => [nameOf(row), row]));
  const before = new Map((fitted ?? []).map((row) => [nameOf(row), row]));
  for (const [name, line] of shown.lines) {
    line.element.classList.toggle("chosen", line.experiment === chosen);
    line.element.classList.toggle("stale", !now.has(name));
    const row = now.get(name) ?? (line.empty ? before.get(name) : null);
    if (row) fill(line, row, before.get(name));
  }
}

function build(shape, all, moved, choose) {
  const heads = ["experiment", "channel", "RMSE", ...(moved ? ["fitted model"] : []), "sensor noise", "RMSE / noise", "fit"];
  const lines = new Map(all.map((row) => {
    const go = () => choose(row.experiment);
    const cells = heads.map((head) => el("td", { class: head === "channel" ? "left" : null }));
    // For the mouse; the keyboard has the buttons of the experiments.
    const element = el("tr", { onclick: go }, cells);
    return [nameOf(row), { element, cells, moved, experiment: row.experiment, empty: true }];
  }));
  shown = { shape, lines };
  byId("errors").replaceChildren(table(heads, [...lines.values()].map((line) => line.element), ["channel"]));
}

function fill(line, row, old) {
  const [rmse, over] = [line.cells[2], line.cells[line.moved ? 5 : 4]];
  const texts = [row.experiment, row.spoken, row.rmse_text, ...(line.moved ? [old?.rmse_text ?? ""] : []), row.noise_text, row.over_noise_text, row.fit_text];
  texts.forEach((text, index) => { if (line.cells[index].textContent !== text) line.cells[index].textContent = text; });
  rmse.dataset.rmse = row.rmse;
  // A difference that the digits do not show is none.
  rmse.className = !old || row.rmse_text === old.rmse_text ? "" : row.rmse > old.rmse ? "bad" : "good";
  over.className = row.fails ? "bad" : "good";
  line.empty = false;
}
