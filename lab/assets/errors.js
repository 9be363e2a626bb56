// The error of every series, as it is while sliders move; a row chooses its experiment.
import { byId, el, table } from "./dom.js";

/** `rows` from the server; `fitted` are those of the model without moved sliders, or null. */
export function showErrors(rows, fitted, chosen, choose) {
  const before = new Map((fitted ?? []).map((row) => [`${row.experiment}/${row.channel}`, row]));
  const heads = ["experiment", "channel", "RMSE", ...(fitted ? ["fitted model"] : []), "sensor noise", "RMSE / noise", "fit"];
  const lines = rows.map((row) => {
    const old = before.get(`${row.experiment}/${row.channel}`);
    const go = () => choose(row.experiment);
    return el("tr", {
      class: row.experiment === chosen ? "chosen" : null, tabindex: 0, onclick: go,
      onkeydown: (event) => { if (event.key === "Enter") go(); },
    },
    el("td", {}, row.experiment),
    el("td", { class: "left" }, row.spoken),
    el("td", { "data-rmse": row.rmse, class: old && row.rmse > old.rmse ? "bad" : old && row.rmse < old.rmse ? "good" : null }, row.rmse_text),
    fitted ? el("td", {}, old?.rmse_text ?? "") : null,
    el("td", {}, row.noise_text),
    el("td", { class: row.over_noise > 1.5 ? "bad" : "good" }, row.over_noise_text),
    el("td", {}, row.fit_text));
  });
  byId("errors").replaceChildren(table(heads, lines, ["channel"]));
}
