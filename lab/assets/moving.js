// Curves while a hand moves a slider: drawn on a canvas of our own over the axes of the plot, which is much quicker
// than the library's redraw. When the hand rests, the library draws them, and the canvas is cleared.
import { colour } from "./plots.js";

/** Places of a channel's traces: measured, fitted, model, difference. */
const [FITTED, MODEL, DIFFERENCE] = [1, 2, 3];
const TRACES = 4;

let canvas = null;
// The library's curves that are hidden now.
let hidden = null;

function over(plot, { width, height }) {
  if (!canvas || canvas.parentElement !== plot) {
    canvas = document.createElement("canvas");
    canvas.className = "moving";
    plot.append(canvas);
  }
  const dots = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * dots) || canvas.height !== Math.round(height * dots)) {
    canvas.width = Math.round(width * dots);
    canvas.height = Math.round(height * dots);
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(dots, 0, 0, dots, 0, 0);
  pen.clearRect(0, 0, width, height);
  return pen;
}

/** The library's own model and difference are out of date while the hand moves. */
function hideOld(plot, channels) {
  if (hidden) return;
  hidden = [...plot.querySelectorAll(".scatterlayer .trace")].filter((node) => {
    const index = node.__data__?.[0]?.trace?.index;
    return index < TRACES * channels && [FITTED, MODEL, DIFFERENCE].includes(index % TRACES);
  });
  for (const node of hidden) node.style.visibility = "hidden";
}

function line(pen, x, y, curve, strokeStyle, width, dash) {
  pen.save();
  pen.beginPath();
  pen.rect(x._offset, y._offset, x._length, y._length);
  pen.clip();
  pen.beginPath();
  pen.strokeStyle = strokeStyle;
  pen.lineWidth = width;
  pen.setLineDash(dash);
  pen.lineJoin = "round";
  let gap = true;
  for (let k = 0; k < curve.x.length; k += 1) {
    const value = curve.y[k];
    if (Number.isNaN(value)) { gap = true; continue; }
    const [left, top] = [x._offset + x.l2p(curve.x[k]), y._offset + y.l2p(value)];
    if (gap) pen.moveTo(left, top); else pen.lineTo(left, top);
    gap = false;
  }
  pen.stroke();
  pen.restore();
}

/** Draws the curves of `now` and, dotted, the model of `fitted`; true where that could be done. */
export function paint(plot, now, fitted) {
  const axes = plot._fullLayout;
  if (!axes?.xaxis?.l2p || axes.xaxis._offset === undefined) return false;
  const pen = over(plot, axes);
  hideOld(plot, now.channels.length);
  const [ghost, model, difference] = ["ghost", "model", "push"].map(colour);
  const name = (k) => `yaxis${k === 1 ? "" : k}`;
  now.channels.forEach((channel, index) => {
    const [top, low] = [axes[name(2 * index + 1)], axes[name(2 * index + 2)]];
    line(pen, axes.xaxis, top, fitted.channels[index].simulated, ghost, 1.3, [2, 3]);
    line(pen, axes.xaxis, top, channel.simulated, model, 1.5, []);
    line(pen, axes.xaxis, low, channel.residual, difference, 0.9, []);
  });
  return true;
}

/** The library has drawn. */
export function clear() {
  for (const node of hidden ?? []) node.style.visibility = "";
  hidden = null;
  canvas?.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
}
