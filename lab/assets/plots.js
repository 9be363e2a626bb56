// How every plot looks.

/** The library is large: the page comes first, and drawing waits for it. */
export const library = window.Plotly ? Promise.resolve()
  : new Promise((resolve) => document.getElementById("plot-library").addEventListener("load", resolve, { once: true }));

/** A colour of the page, by its name in lab.css. */
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

export const axis = (title, more = {}) => ({
  title: { text: title, font: { size: 12 }, standoff: 6 },
  gridcolor: colour("line"), zerolinecolor: colour("line"), linecolor: colour("line"),
  exponentformat: "SI", automargin: true, ...more,
});

export const layout = (more = {}) => ({
  paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
  font: { family: "system-ui, sans-serif", size: 12, color: colour("text") },
  margin: { l: 62, r: 12, t: 24, b: 40 },
  showlegend: true, legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom", font: { size: 11 } },
  hoverlabel: { bgcolor: colour("card"), bordercolor: colour("line"), font: { color: colour("text") } },
  modebar: { bgcolor: "rgba(0,0,0,0)", color: colour("quiet"), activecolor: colour("accent") },
  ...more,
});

export const config = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["select2d", "lasso2d"] };

/** Draws, or draws anew. */
export async function draw(element, traces, form, more = {}) {
  await library;
  return Plotly.react(element, traces, form, { ...config, ...more });
}

/** Calls when light and dark change. */
export const onTheme = (call) => matchMedia("(prefers-color-scheme: dark)").addEventListener("change", call);
