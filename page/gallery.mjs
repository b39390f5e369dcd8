// The gallery, in docs/gallery: node page/gallery.mjs [HOST_SIM PAGE.html FOLDER]
//
// A point, a vertebra in water, in tissue and by plane waves, and a picture of laminae: pages below 2 MB. The
// command writes them; plane waves are sums of what it simulates element by element.

import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { argv } from "node:process";
import { fileURLToPath } from "node:url";
import { crc32 } from "node:zlib";

/** An .npz archive of arrays: type, shape and numbers. */
export function archive(arrays) {
  const [files, table] = [[], []];
  for (const [key, [type, shape, values]] of Object.entries(arrays)) {
    const head = `{'descr': '${type}', 'fortran_order': False, 'shape': (${shape.map((n) => `${n},`).join("")}), }`;
    const start = Buffer.concat([Buffer.from("\x93NUMPY\x01\x00", "latin1"), Buffer.alloc(2), Buffer.from(head.padEnd(117) + "\n")]);
    start.writeUInt16LE(118, 8);
    const bytes = Buffer.concat([start, Buffer.from(values.buffer)]);
    const name = Buffer.from(`${key}.npy`);
    const local = Buffer.alloc(30);
    local.writeUInt32LE(0x04034b50, 0);
    local.writeUInt16LE(20, 4);
    local.writeUInt32LE(crc32(bytes), 14);
    local.writeUInt32LE(bytes.length, 18);
    local.writeUInt32LE(bytes.length, 22);
    local.writeUInt16LE(name.length, 26);
    const central = Buffer.alloc(46);
    central.writeUInt32LE(0x02014b50, 0);
    central.writeUInt16LE(20, 4);
    local.copy(central, 6, 4, 30);
    central.writeUInt32LE(Buffer.concat(files).length, 42);
    table.push(central, name);
    files.push(local, name, bytes);
  }
  const [own, contents] = [Buffer.concat(files), Buffer.concat(table)];
  const end = Buffer.alloc(22);
  end.writeUInt32LE(0x06054b50, 0);
  end.writeUInt16LE(Object.keys(arrays).length, 8);
  end.writeUInt16LE(Object.keys(arrays).length, 10);
  end.writeUInt32LE(contents.length, 12);
  end.writeUInt32LE(own.length, 16);
  return Buffer.concat([own, contents, end]);
}

/** Values of an archive's float64 scalar. */
export const of = (...values) => ["<f8", values.length > 1 ? [values.length] : [], Float64Array.from(values)];

/** Positions of elements about 0, or angles. */
export const even = (count, step) => of(...Array.from({ length: count }, (_, k) => (k - (count - 1) / 2) * step));

/** The command in a folder. */
export const commandIn = (program, folder) => (...words) =>
  execFileSync(program, words, { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });

const PITCH = 0.308e-3;
const FINE = 80e6;

/** Writes plane waves on a simulated vertebra, sampled at 20 MHz in 16 bits. */
export function planeWaves(hostSim, folder, name, { elements, waves, step, end }) {
  const at = (file) => join(folder, file);
  // Aperture of one element.
  writeFileSync(at("elements.toml"), `[simulate]\nphantom = "vertebra"\n[simulate.scanner]\nelements = ${elements}\n` +
    `beams = ${elements}\nfs = ${FINE}\nf_number = 100.0\ndepth_start = 10e-3\ndepth_end = ${end}\n`);
  hostSim("simulate", "--config", "elements.toml", "-o", "elements.npz");
  const file = readFileSync(at("elements.npz"));
  // Arrays are stored, each after its name and its .npy header.
  const array = (key) => {
    const start = file.indexOf("\x93NUMPY", file.indexOf(`${key}.npy`), "latin1");
    return start + 10 + file.readUInt16LE(start + 8);
  };
  const samples = Number(/'shape': \(\d+, \d+, (\d+)\)/.exec(file.toString("latin1", array("rf") - 128, array("rf")))[1]);
  const rf = new Float32Array(file.buffer.slice(file.byteOffset + array("rf"), file.byteOffset + array("rf") + 4 * elements ** 2 * samples));
  const kept = Math.floor(samples / 4);
  const summed = new Float64Array(waves * elements * kept);
  for (let wave = 0; wave < waves; wave += 1) {
    const sine = Math.sin((wave - (waves - 1) / 2) * step);
    for (let sender = 0; sender < elements; sender += 1) {
      const late = ((sender - (elements - 1) / 2) * PITCH * sine / 1540) * FINE;
      const [whole, part] = [Math.floor(-late), -late - Math.floor(-late)];
      for (let element = 0; element < elements; element += 1) {
        const [from, to] = [(sender * elements + element) * samples, (wave * elements + element) * kept];
        for (let k = 0; k < kept; k += 1) {
          const n = 4 * k + whole;
          if (n >= 0 && n + 1 < samples) summed[to + k] += rf[from + n] * (1 - part) + rf[from + n + 1] * part;
        }
      }
    }
  }
  const most = summed.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  writeFileSync(at(name), archive({
    rf: ["<i2", [waves, elements, kept], Int16Array.from(summed, (value) => Math.round((value / most) * 32767))],
    fs: of(FINE / 4), t0: of(file.readDoubleLE(array("t0"))), c: of(1540), f0: of(5e6), element_x: even(elements, PITCH), tx_angle: even(waves, step),
  }));
  writeFileSync(at(`${name}.truth.npz`), readFileSync(at("elements.npz.truth.npz")));
}

/** Writes the gallery; returns the pages' paths. */
export function gallery(program, built, out) {
  mkdirSync(out, { recursive: true });
  const folder = mkdtempSync(join(tmpdir(), "gallery-"));
  const hostSim = commandIn(program, folder);
  const limit = String(((2e6 - statSync(built).size) / 1e6 - 0.02).toFixed(3));
  const view = (recording, name) => {
    const words = [...(recording ? [recording, "--limit", limit] : []), "--page", built, "-o", join(out, `${name}.html`)];
    console.log(`${name}: ${hostSim("view", ...words).trim()}`);
    return join(out, `${name}.html`);
  };
  const simulate = (name, text) => {
    writeFileSync(join(folder, "scene.toml"), `[simulate]\n${text}`);
    hostSim("simulate", "--config", "scene.toml", "-o", name);
  };
  const small = "elements = 48\nbeams = 48\nfs = 20e6\n";
  simulate("point.npz", `phantom = "point"\n[simulate.scanner]\n${small}first_beam = 18.0\nbeam_step = 0.25\ndepth_start = 12e-3\ndepth_end = 18e-3\n`);
  simulate("tissue.npz", `phantom = "vertebra"\ntissue = true\n[simulate.scanner]\n${small}depth_start = 10e-3\ndepth_end = 22e-3\n`);
  planeWaves(hostSim, folder, "plane-waves.npz", { elements: 64, waves: 5, step: 0.06, end: 0.034 });
  simulate("laminae.npz", `phantom = "laminae"\nthickness = 5e-4\ntissue_density = 20.0\n[simulate.scanner]\n` +
    "elements = 64\nbeams = 64\nfs = 20e6\ndepth_end = 30e-3\n");
  hostSim("beamform", "laminae.npz", "--method", "das", "-o", "lines.npz", "--pixel-size", "1e-4", "--image", "picture.png");
  const pages = [view("point.npz", "point"), view(null, "vertebra-in-water"), view("tissue.npz", "vertebra-in-tissue"),
    view("plane-waves.npz", "plane-waves"), view("picture.png", "picture")];
  rmSync(folder, { recursive: true });
  return pages;
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const usual = ["../target/release/host-sim", "../target/release/page.html", "../docs/gallery"];
  gallery(...usual.map((path, k) => (argv[2 + k] ? resolve(argv[2 + k]) : fileURLToPath(new URL(path, import.meta.url)))));
}
