// A worker: one instance of the module, one answer for each message.
// Classic, since workers from blobs that are modules do not start from disk.

/** @type {any} */
let exports = null;
const encoder = new TextEncoder();
const decoder = new TextDecoder();

/**
 * Calls a function of the module.
 * @param {string} name
 * @param {number[]} numbers
 * @param {string | ArrayBuffer | SharedArrayBuffer | undefined} argument
 */
function call(name, numbers, argument) {
  const bytes = typeof argument === "string" ? encoder.encode(argument) : new Uint8Array(argument ?? new ArrayBuffer(0));
  const at = exports.input(bytes.length);
  new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
  let failed = 1;
  try {
    failed = exports[name](...numbers);
  } catch (error) {
    // The module ended with a panic, whose message it kept; it cannot go on.
    return { failed: 2, text: copied(0, decoder.decode.bind(decoder)) || String(error), bytes: null };
  }
  const text = copied(0, (part) => decoder.decode(part));
  return { failed, text, bytes: failed ? null : copied(1, (part) => part.slice().buffer) };
}

/**
 * A part of the last answer.
 * @template T
 * @param {number} part
 * @param {(bytes: Uint8Array) => T} take
 * @returns {T}
 */
function copied(part, take) {
  return take(new Uint8Array(exports.memory.buffer, exports.output(part), exports.output_length(part)));
}

self.onmessage = ({ data }) => {
  if (data.module) {
    exports = new WebAssembly.Instance(data.module, {}).exports;
    self.postMessage({ failed: 0, text: "null", bytes: null });
    return;
  }
  const answer = call(data.name, data.numbers, data.argument);
  // @ts-ignore: the library's type of `self` is that of a window
  self.postMessage({ ...answer, memory: exports.memory.buffer.byteLength }, answer.bytes ? [answer.bytes] : []);
};
