// The pendulum as a drawing, with the places of the constants; the one that is being typed is marked.

const SVG = "http://www.w3.org/2000/svg";

function shape(tag, attributes, ...children) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

const text = (x, y, words, anchor = "start") => shape("text", { x, y, "text-anchor": anchor }, words);

/** A line with an arrow at both ends. */
function measure(x1, y1, x2, y2) {
  return shape("line", { x1, y1, x2, y2, class: "measure", "marker-start": "url(#sketch-tip)", "marker-end": "url(#sketch-tip)" });
}

/** What can be known: key in bench.toml, symbol in the drawing, unit, words, and how it is had. */
export const CONSTANTS = [
  { key: "gravity", symbol: "g", unit: "m/s²", words: "gravity", how: "9.81 nearly everywhere", usual: 9.81 },
  { key: "torque_constant", symbol: "τ", unit: "N m/A", words: "torque constant of the motor", how: "from its data sheet" },
  { key: "body_mass", symbol: "m_b", unit: "kg", words: "mass of the body without the wheel", how: "weigh it" },
  { key: "wheel_mass", symbol: "m_w", unit: "kg", words: "mass of the wheel with what turns with it", how: "weigh it" },
  { key: "pivot_to_wheel", symbol: "k", unit: "m", words: "from the pivot to the wheel's axis", how: "measure it with a ruler" },
  { key: "pivot_to_com", symbol: "l", unit: "m", words: "from the pivot to the body's own centre of mass", how: "balance the body without the wheel on an edge" },
  { key: "gravity_torque", symbol: "G", unit: "N m", words: "torque that holds the body level, in place of masses and lengths", how: "with a spring scale: force times arm" },
];

/** The drawing; `mark(key)` marks a constant in it. */
export function sketch() {
  const parts = new Map();
  const part = (key, ...children) => {
    const group = shape("g", { class: "part" }, ...children);
    parts.set(key, group);
    return group;
  };
  const tip = shape("marker", { id: "sketch-tip", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto-start-reverse" }, shape("path", { d: "M0 0 L8 4 L0 8 z" }));
  const drawing = shape("svg", { viewBox: "0 0 330 330", class: "sketch", role: "img", "aria-label": "The pendulum hanging from its pivot: body, its centre of mass, and at its end the wheel on the motor" },
    shape("defs", {}, tip),
    // The support and the pivot.
    shape("path", { d: "M95 34 h80", class: "ground" }), ...[100, 115, 130, 145, 160].map((x) => shape("path", { d: `M${x} 34 l10 -10`, class: "ground" })),
    // The vertical, and the body, drawn at an angle that is positive.
    shape("path", { d: "M135 40 V300", class: "vertical" }),
    shape("g", { transform: "rotate(-18 135 40)" },
      part("body_mass", shape("rect", { x: 124, y: 30, width: 22, height: 218, rx: 9, class: "body" }), shape("text", { x: 108, y: 118, "text-anchor": "end" }, "m_b")),
      part("wheel_mass", shape("circle", { cx: 135, cy: 240, r: 48, class: "wheel" }), ...[0, 60, 120].map((turn) => shape("path", { d: "M87 240 H183", class: "spoke", transform: `rotate(${turn} 135 240)` })), shape("text", { x: 80, y: 285, "text-anchor": "end" }, "m_w")),
      part("torque_constant", shape("circle", { cx: 135, cy: 240, r: 12, class: "motor" }), shape("path", { d: "M135 205 A35 35 0 0 1 168 229", class: "measure", "marker-end": "url(#sketch-tip)" }), shape("text", { x: 186, y: 208 }, "τ · i")),
      part("pivot_to_com", shape("circle", { cx: 135, cy: 140, r: 5, class: "centre" }), measure(162, 40, 162, 140), shape("path", { d: "M135 140 H166 M135 40 H166", class: "thin" }), shape("text", { x: 168, y: 98 }, "l")),
      part("pivot_to_wheel", measure(206, 40, 206, 240), shape("path", { d: "M168 40 H210 M135 240 H210", class: "thin" }), shape("text", { x: 212, y: 150 }, "k")),
      shape("circle", { cx: 135, cy: 40, r: 6, class: "pivot" })),
    shape("path", { d: "M135 150 A110 110 0 0 0 158 147", class: "angle", "marker-end": "url(#sketch-tip)" }), text(138, 172, "+α"),
    part("gravity", shape("path", { d: "M30 60 V120", class: "measure", "marker-end": "url(#sketch-tip)" }), text(38, 96, "g")),
    part("gravity_torque", shape("path", { d: "M104 62 A38 38 0 0 1 166 18", class: "measure" }), text(70, 66, "G")));
  return { drawing, mark: (key) => parts.forEach((group, own) => group.classList.toggle("marked", own === key)) };
}
