// Talking with the server: requests, and the socket that carries curves and events.

async function answer(response) {
  const text = await response.text();
  let body = null;
  try { body = text ? JSON.parse(text) : null; } catch { body = { message: text.trim() }; }
  if (!response.ok) throw new Error(body?.message ?? `the server answered ${response.status}`);
  return body;
}

/** A request; what a browser says where nobody answers is no sentence for people. */
async function reach(path, options) {
  try {
    return await fetch(path, options);
  } catch {
    throw new Error(SILENT);
  }
}

/** The message where nobody answers. */
export const SILENT = "The lab does not answer: its program has ended, or this browser cannot reach it. Start `flywheel lab` again; everything that was kept is in the bench folder.";

export const get = async (path) => answer(await reach(path));

export const post = async (path, body) => answer(await reach(path, {
  method: "POST",
  headers: { "content-type": "application/json" },
  body: JSON.stringify(body),
}));

/** Sends a file, or, without one, forgets what was sent. */
export const send = async (path, body) => answer(await reach(path, body ? { method: "POST", body } : { method: "DELETE" }));

/** A file that the server makes. */
export async function download(path) {
  const response = await reach(path);
  return response.ok ? response.blob() : answer(response);
}

export const callOff = () => send("/api/work");

let socket = null;
let opened = null;
let count = 0;
const waiting = new Map();
let onEvent = () => {};
let isGone = false;

/** Opens the socket; `listener` is given every event, and "connected" and "gone". */
export function listen(listener) {
  onEvent = listener;
  connect();
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  opened = new Promise((resolve) => {
    socket.onopen = () => { isGone = false; resolve(); onEvent({ event: "connected" }); };
  });
  socket.onmessage = ({ data }) => {
    if (typeof data === "string") {
      const event = JSON.parse(data);
      if (event.event === "refused") settleAll(new Error(event.message));
      else onEvent(event);
      return;
    }
    const curves = decoded(data);
    waiting.get(curves.id)?.resolve(curves);
    waiting.delete(curves.id);
  };
  socket.onclose = () => {
    settleAll(new Error(SILENT));
    // It is tried again and again, and told once.
    if (!isGone) onEvent({ event: "gone" });
    isGone = true;
    setTimeout(connect, 1000);
  };
}

function settleAll(error) {
  for (const { reject } of waiting.values()) reject(error);
  waiting.clear();
}

/** Asks for the curves of an experiment. */
export async function ask(question) {
  await opened;
  count += 1;
  const id = count;
  const promise = new Promise((resolve, reject) => waiting.set(id, { resolve, reject }));
  socket.send(JSON.stringify({ id, ...question }));
  return promise;
}

/** Header, and arrays in place of where they are. */
function decoded(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const numbers = new Float64Array(buffer, Math.ceil((4 + length) / 8) * 8);
  const curve = ([at, size]) => ({
    x: numbers.subarray(at, at + size),
    y: numbers.subarray(at + size, at + 2 * size),
  });
  for (const channel of header.channels) {
    for (const part of ["measured", "simulated", "residual"]) channel[part] = curve(channel[part]);
  }
  return header;
}
