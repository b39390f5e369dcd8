"use strict";
// All words of the page but those of the parameters, which come from their one description.

const WORDS = {
  title: "bonebeam",
  loading: "Starting …",
  noWorker: "A worker cannot start: this browser does not allow one here. Open the page in another browser, or from a server.",
  noSimd: "This browser lacks WebAssembly with vectors (simd128), which all browsers have had since 2023. Use a newer one.",
  ended: "The computation ended with a fault of the program; please report it:",
  drop: "Drop a recording (.npz), a picture (PNG, JPEG) or settings (.toml) here, or choose a file.",
  dropped: "Drop the file to open it",
  empty: "No recording yet.",
  none: "the default",
  otherFile: (/** @type {string} */ name) =>
    `${name} is none of ours: expected a recording or lines as .npz, a picture as PNG or JPEG, or settings as .toml. ` +
    "host-sim convert makes .npz of other formats.",
  tooLarge: (/** @type {string} */ name, /** @type {number} */ size) =>
    `${name} has ${(size / 2 ** 20).toFixed(0)} MB; expected at most 256 MB. host-sim view FILE -o page.html cuts it.`,
  aligned: "This file holds aligned data; the page beamforms recordings (`rf` or `iq`) and shows lines (`z`).",
  channel: (/** @type {any} */ a) =>
    `${a.frames > 1 ? `${a.frames} frames of ` : ""}${a.transmits} transmits, ${a.elements} elements, ` +
    `${a.samples} samples of ${a.iq ? "I/Q" : "RF"} at ${short(a.fs / 1e6)} MHz, centre frequency ${short(a.f0 / 1e6)} MHz`,
  lines: (/** @type {any} */ a) => `lines, ${a.frames} ${a.frames > 1 ? "frames, the first is shown" : "frame"}`,
  picture: (/** @type {any} */ a) => `a picture of ${a.rows} × ${a.columns} pixels`,
  shape: (/** @type {any} */ s) => (s ? `${s.lines} lines of ${s.samples} samples. ` : ""),
  computed: (/** @type {number} */ seconds, /** @type {boolean} */ coarse) =>
    `${coarse ? "Coarse" : "Full"} picture in ${(1000 * seconds).toFixed(0)} ms. `,
  hashes: (/** @type {string} */ image, /** @type {string} */ map) =>
    `xxh128 of image.npy ${image}${map ? `, of map.npy ${map}` : ""}`,
  command: "Same bits by the command, with the recording and the settings saved from here:",
  image: "B-mode",
  map: "Phase symmetry",
  bone: (/** @type {number} */ lines) => `Bone in ${lines} lines.`,
  distance: (/** @type {number} */ mm) => `Mean distance to the known surface ${mm.toFixed(2)} mm.`,
  truth: "known surface, drawn 1 mm above",
  cursor: (/** @type {number} */ x, /** @type {number} */ z, /** @type {string} */ value) =>
    `x ${x.toFixed(2)} mm, depth ${z.toFixed(2)} mm: ${value}`,
  outside: "outside",
  widths: (/** @type {string} */ six, /** @type {string} */ twelve) => `width at −6 dB ${six}, at −12 dB ${twelve}`,
  gcnr: (/** @type {string} */ value) => `gCNR of the two boxes ${value}`,
  boxes: "Drag box 1, then box 2, over the picture.",
  described: (/** @type {string} */ what) =>
    `${what}. Arrow keys move the cursor, plus and minus zoom, 0 shows all, space plays the frames.`,
  profile: "Level along the row through the cursor, dB over mm",
};

/** A number with at most four digits that count. @param {number} value */
function short(value) {
  return String(Number(value.toPrecision(4)));
}
