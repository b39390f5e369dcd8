// The live page in headless Chromium: node page/test.mjs HOST_SIM PAGE.html FOLDER NATIVE [PART,…]
//
// From disk, and from a server with and without the headers for shared memory. Results are compared with those of the
// command, bit by bit. Pictures of the page are left in FOLDER.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { basename, join, resolve } from "node:path";
import { argv } from "node:process";
import { chromium } from "playwright-core";
import { archive, commandIn, even, gallery, of } from "./gallery.mjs";

const [program, built, folder, native] = argv.slice(2, 6).map((path) => resolve(path));
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
mkdirSync(folder, { recursive: true });
const at = (name) => join(folder, name);
const hostSim = commandIn(program, folder);

/** Settings as the controls take them: each method and most of the controls. */
const SETTINGS = [
  {},
  { "beamform.method": "das" },
  { "beamform.method": "mv", "beamform.temporal_half_window": "2", "image.dynamic_range": "50" },
  { "beamform.method": "esmv", "beamform.beta": "0.1", "beamform.diagonal_loading": "0.01" },
  { "beamform.method": "esmv", "beamform.rank": "2", "beamform.subaperture_ratio": "0.4" },
  { "beamform.f_number": "2", "beamform.depth_step": "4", "image.median": "true" },
  { "beamform.method": "mv", "beamform.postfilter": "coherence-factor", "beamform.sub_lines": "4" },
  { "beamform.sound_speed": "1480", "phase_symmetry.scales": "2^-5,2^-6", "phase_symmetry.threshold": "5" },
  { "beamform.covariance": "forward", "beamform.exclude_first": "true", "image.depth": "0.03", "image.width": "0.015" },
  { "beamform.method": "das", "beamform.apodization": "hann", "image.pixel_size": "0.0001", "phase_symmetry.wavelengths": "0.002,0.004" },
];
const SETTING_REFUSED = { "beamform.f_number": "-1" };

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync"],
});

/** A tab whose requests and messages are failures, but those of the page itself. */
async function tab(address, options = {}, before = async () => {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, acceptDownloads: true, ...options });
  const wrong = [];
  page.on("console", (message) => wrong.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("request", (request) => {
    const url = request.url();
    if (url.split("#")[0] !== address.split("#")[0] && !/^(blob|data):/.test(url)) wrong.push(`requests ${url}`);
  });
  await before(page);
  const begin = Date.now();
  await page.goto(address);
  page.wrong = wrong;
  page.begin = begin;
  return page;
}

/** Waits for the full picture, or the message. */
async function settled(page) {
  // `waitForFunction` takes a promise for true.
  for (const begin = Date.now(); Date.now() < begin + 120_000; await new Promise((resolve) => setTimeout(resolve, 20))) {
    const [message, status] = await page.evaluate(async () => {
      await window.page?.done;
      return ["message", "status"].map((id) => document.getElementById(id).textContent);
    });
    if (message || !/^Starting|Coarse/.test(status)) return message;
  }
  throw new Error(`the page does not end: ${await page.textContent("#status")}`);
}

/** What the page has computed of settings A. */
async function results(page, settings) {
  await page.evaluate((given) => { window.page.shown.value = "both"; window.page.use(given); }, settings);
  assert.equal(await settled(page), "");
  return page.evaluate(() => {
    const { image, map, toml } = window.page.results[0];
    const bytes = (picture) => btoa(Array.from(new Uint8Array(picture.levels.buffer), (b) => String.fromCharCode(b)).join(""));
    return { hash: image.hash, image: bytes(image), map: bytes(map), toml };
  });
}

/** The numbers of an .npy file. */
function numbers(name) {
  const bytes = readFileSync(at(name));
  return bytes.subarray(10 + bytes.readUInt16LE(8)).toString("base64");
}

/** The same by the command, with the recording and the settings that the page saves. */
function compare(found, what) {
  writeFileSync(at("settings.toml"), found.toml);
  hostSim("beamform", "saved.npz", "--config", "settings.toml", "-o", "lines.npz", "--image", "image.npy", "--bone-map", "map.npy");
  hostSim("phase-symmetry", "image.npy", "--pad", "-o", "again.npy");
  const [, hash] = /image\.npy, xxh128 ([0-9a-f]{32})/.exec(readFileSync(at("again.npy.config.toml"), "utf8"));
  assert.equal(found.hash, hash, `the hash of the image, ${what}`);
  assert.equal(found.image, numbers("image.npy"), `the image, ${what}`);
  assert.equal(found.map, numbers("map.npy"), `the bone map, ${what}`);
}

/** Every control that is seen first, moved by mouse or keyboard: another picture, and the command's. */
async function moved(page) {
  const texts = {
    "beamform.beta": "0.2", "beamform.sub_lines": "2", "beamform.depth_step": "2", "beamform.sound_speed": "1500",
    "image.pixel_size": "0.0002", "phase_symmetry.scales": "2^-5",
  };
  const ids = await page.$$eval("#controls > div .control", (all) => all.map((one) => one.querySelector("input, select").id));
  for (const id of ids) {
    const before = await results(page, id === "beamform.beta" ? { "beamform.method": "esmv" } : {});
    const control = page.locator(`[id='${id}']`);
    const slider = page.locator(`[id='${id}'] ~ input[type=range]`);
    const kind = await control.evaluate((own) => own.type);
    if (await slider.count()) {
      await slider.focus();
      for (let k = 0; k < 5; k += 1) await page.keyboard.press("ArrowRight");
    } else if (kind === "checkbox") {
      await control.check();
    } else if (kind === "select-one") {
      await control.selectOption({ index: 1 });
    } else {
      await control.fill(texts[id]);
      await control.press("Enter");
    }
    const given = await page.evaluate(() => window.page.settings[0]);
    assert.ok(id in given, `${id} is set`);
    const after = await results(page, given);
    assert.ok(after.hash !== before.hash || after.map !== before.map, `${id} changes a picture`);
    compare(after, id);
  }
  console.log(`${ids.length} controls moved: the command's bits`);
}

async function saved(page, button, name) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click(button)]);
  await download.saveAs(at(name));
}

/** Drops a file on the page. */
async function drop(page, name, bytes) {
  const before = { name, data: bytes.toString("base64") };
  await page.evaluate(({ name, data }) => {
    const file = new File([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], name);
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(file);
    document.getElementById("status").textContent = "Starting";
    document.getElementById("message").textContent = "";
    dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
  }, before);
  return settled(page);
}

async function fromDisk(file) {
  const page = await tab(`file://${file}`);
  await page.waitForFunction(() => window.page?.results[0]);
  console.log(`from disk: first picture after ${Date.now() - page.begin} ms`);
  assert.equal(await settled(page), "");
  await saved(page, "#save-recording", "saved.npz");
  for (const settings of SETTINGS) {
    compare(await results(page, settings), JSON.stringify(settings));
  }
  console.log(`${SETTINGS.length} settings: images, their hashes and bone maps have the command's bits`);
  await moved(page);
  await saved(page, "#save-toml", "settings.toml");
  assert.equal(readFileSync(at("settings.toml"), "utf8"), (await page.evaluate(() => window.page.results[0].toml)));
  await page.evaluate((given) => window.page.use(given), SETTING_REFUSED);
  assert.match(await settled(page), /--f-number .* is -1; expected/);
  assert.deepEqual(page.wrong, []);
  await page.close();
}

/** A user's way from nothing: a recording, its page, a setting, the files saved, and the command that the page shows. */
async function task() {
  const begin = Date.now();
  mkdirSync(at("task"), { recursive: true });
  hostSim("simulate", "--config", "small.toml", "-o", "mine.npz");
  hostSim("view", "mine.npz", "--page", built, "-o", "mine.html");
  const page = await tab(`file://${at("mine.html")}`);
  assert.equal(await settled(page), "");
  await page.selectOption("[id='beamform.method']", "mv");
  assert.equal(await settled(page), "");
  await saved(page, "#save-recording", "task/mine.npz");
  await saved(page, "#save-toml", "task/settings.toml");
  const own = commandIn(program, at("task"));
  own(...(await page.textContent("#command-line")).split(" ").slice(1));
  own("phase-symmetry", "image.npy", "--pad", "-o", "again.npy");
  const [, hash] = /xxh128 of image\.npy ([0-9a-f]{32})/.exec(await page.textContent("#hashes"));
  assert.ok(readFileSync(at("task/again.npy.config.toml"), "utf8").includes(`image.npy, xxh128 ${hash}`), "the hash at the foot");
  console.log(`from nothing by a recording, a page, a setting and its TOML to the same bits by the command: ${Date.now() - begin} ms`);
  assert.deepEqual(page.wrong, []);
  await page.close();
}

/** Files of every kind, and every error. */
async function files() {
  const page = await tab(`file://${built}`);
  await settled(page);
  assert.equal(await page.textContent("#about"), await page.evaluate(() => WORDS.drop));
  hostSim("simulate", "--config", "small.toml", "-o", "own.npz");
  const own = readFileSync(at("own.npz"));
  assert.equal(await drop(page, "own.npz", own), "");
  assert.match(await page.textContent("#about"), /^own\.npz: 32 transmits, 32 elements/);
  const { hash } = await results(page, {});
  hostSim("beamform", "own.npz", "-o", "lines.npz", "--image", "image.png");
  assert.equal(await drop(page, "lines.npz", readFileSync(at("lines.npz"))), "");
  assert.equal((await results(page, {})).hash, hash, "the image of the program's lines");
  // A picture, and the same as JPEG by the page's own browser.
  const png = readFileSync(at("image.png"));
  assert.equal(await drop(page, "image.png", png), "");
  assert.match(await page.textContent("#status"), /Bone in \d+ lines/);
  hostSim("surface", "image.png", "--pixel-size", "0.0001", "-o", "surface.csv");
  const rows = readFileSync(at("surface.csv"), "utf8").trim().split("\n").length - 1;
  assert.equal(await page.evaluate(() => window.page.results[0].points.length), rows, "points of a picture");
  const jpeg = await page.evaluate(() => new Promise((resolve) => {
    window.page.view.bitmap(window.page.results[0].image, false)
      .toBlob((blob) => blob.arrayBuffer().then((b) => resolve(btoa(String.fromCharCode(...new Uint8Array(b))))), "image/jpeg", 0.95);
  }));
  assert.equal(await drop(page, "image.jpg", Buffer.from(jpeg, "base64")), "");
  assert.match(await page.textContent("#about"), /^image\.jpg: a picture of/);
  // Settings.
  writeFileSync(at("dropped.toml"), "[beamform]\nmethod = \"mv\"\n[image]\ndynamic_range = 40.0\npixel_size = 1e-4\n");
  assert.equal(await drop(page, "dropped.toml", readFileSync(at("dropped.toml"))), "");
  assert.equal(await page.inputValue("[id='beamform.method']"), "mv");
  // What is none of ours, damaged, or too large: words, and the page goes on.
  const refused = [
    ["notes.txt", Buffer.from("nothing"), /notes\.txt is none of ours: expected a recording/],
    ["empty.npz", Buffer.alloc(0), /none of ours/],
    ["cut.npz", own.subarray(0, 5000), /the file: is truncated or not an \.npz archive/],
    ["cut.png", png.subarray(0, 500), /the file: is truncated or not a PNG image/],
    ["cut.jpg", Buffer.from(jpeg, "base64").subarray(0, 100), /none of ours/],
    ["bad.toml", Buffer.from("[beamform]\nmethods = 1"), /unknown field `methods`/],
  ];
  for (const [name, bytes, words] of refused) assert.match(await drop(page, name, bytes), words, name);
  await page.evaluate(() => window.page.open({ byteLength: 2 ** 30 }, "large.npz"));
  assert.match(await settled(page), /large\.npz has 1024 MB; expected at most 256 MB/);
  assert.equal(await drop(page, "own.npz", own), "");
  assert.deepEqual(page.wrong, []);
  await page.close();
  // A browser without vectors, and one whose workers do not start.
  const without = await tab(`file://${built}`, {}, (own) =>
    own.addInitScript(() => { WebAssembly.compile = () => Promise.reject(new WebAssembly.CompileError("no simd")); }));
  await without.waitForFunction(() => /simd128/.test(document.getElementById("message").textContent));
  const alone = await tab(`file://${built}`, {}, (own) =>
    own.addInitScript(() => { window.Worker = class { constructor() { setTimeout(() => this.onerror(new Event("error")), 0); } postMessage() {} }; }));
  await alone.waitForFunction(() => /worker cannot start/.test(document.getElementById("message").textContent));
  for (const page of [without, alone]) await page.close();
  console.log(`files: a recording, lines, pictures and settings; ${refused.length + 2} errors in words`);
}

/** The page from a server, with the headers for shared memory or without. */
async function fromServer(file, isolated) {
  const headers = isolated ? { "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp" } : {};
  const server = createServer((request, response) => {
    response.writeHead(request.url === "/" ? 200 : 404, { "Content-Type": "text/html; charset=utf-8", ...headers });
    response.end(readFileSync(file));
  });
  await new Promise((begun) => server.listen(0, "127.0.0.1", begun));
  const page = await tab(`http://127.0.0.1:${server.address().port}/`);
  await page.waitForFunction(() => window.page?.results[0]);
  console.log(`from a server${isolated ? " with shared memory" : ""}: first picture after ${Date.now() - page.begin} ms`);
  await settled(page);
  assert.equal(await page.evaluate(() => self.crossOriginIsolated), isolated);
  const { hash } = await results(page, {});
  assert.deepEqual(page.wrong, []);
  await page.close();
  server.close();
  return hash;
}

/** Times of a frame of 128 lines of 400 depths, here and by the command, in turn. */
async function speed() {
  writeFileSync(at("speed.toml"), SMALL.replace("elements = 32\nbeams = 32", "elements = 64\nbeams = 128\nbeam_step = 0.49606"));
  hostSim("simulate", "--config", "speed.toml", "-o", "speed.npz");
  hostSim("view", "speed.npz", "--page", built, "--limit", "20", "-o", "speed.html");
  const page = await tab(`file://${at("speed.html")}`);
  assert.equal(await settled(page), "");
  const depths = { "beamform.depth_start": "0.0095", "beamform.depth_end": "0.024862", "beamform.sub_lines": "1" };
  for (const [method, least] of [["esmv-rank1", 8], ["mv", 12]]) {
    const seconds = [Infinity, Infinity, Infinity];
    // The fastest of each counts: other work on the machine takes its share.
    for (let k = 0; k < 5 || (k < 40 && (1 / seconds[0] < least || seconds[0] > 3 * seconds[2])); k += 1) {
      for (const coarse of [0, 1]) {
        const run = await page.evaluate(([settings, coarse]) => {
          const { engine } = window.page;
          const wanted = { frame: 0, coarse: coarse === 1, map: false, surface: false, request: engine.newest };
          return engine.run(settings, wanted);
        }, [{ ...depths, "beamform.method": method }, coarse]);
        if (!coarse) assert.deepEqual([run.shape.lines, run.shape.samples], [128, 400]);
        if (!coarse) writeFileSync(at("speed-page.toml"), run.toml);
        seconds[coarse] = Math.min(seconds[coarse], run.seconds);
      }
      const alone = execFileSync(native, [at("speed.npz"), at("speed-page.toml")], { encoding: "utf8" });
      seconds[2] = Math.min(seconds[2], Number(alone));
    }
    const [full, coarse, own] = seconds;
    console.log(`${method}: ${(1 / full).toFixed(1)} frames/s (${least} wanted), coarse ${(1e3 * coarse).toFixed(0)} ms; ` +
      `${(full / own).toFixed(2)} times the ${(1e3 * own).toFixed(1)} ms of two native threads over 128 bits (3 allowed)`);
    assert.ok(1 / full > least / 3, `${method}: ${1 / full} frames/s`);
    assert.ok(full <= 3 * own, `${method}: ${full / own} times the native time`);
  }
  assert.deepEqual(page.wrong, []);
  await page.close();
}

/** 11 plane waves of 128 elements and 2,000 samples: bits, and memory. */
async function waves() {
  let state = 1;
  const noise = () => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return (state >>> 18) - 8192; };
  const saved = archive({
    rf: ["<i2", [11, 128, 2000], Int16Array.from({ length: 11 * 128 * 2000 }, noise)],
    fs: of(20e6), t0: of(0), c: of(1540), f0: of(5e6), element_x: even(128, 0.3e-3), tx_angle: even(11, 0.02),
  });
  writeFileSync(at("saved.npz"), saved);
  const page = await tab(`file://${built}`);
  await settled(page);
  assert.equal(await drop(page, "saved.npz", saved), "");
  compare(await results(page, { "beamform.method": "mv" }), "11 plane waves");
  const memory = await page.evaluate(() => window.page.engine.memory() / 2 ** 20);
  console.log(`11 plane waves of 128 elements and 2,000 samples: the command's bits, ${memory.toFixed(0)} MB of memory`);
  assert.ok(memory <= 300, `${memory} MB`);
  assert.deepEqual(page.wrong, []);
  await page.close();
}

/** The curtain, boxes, zoom and pan by the mouse; a link that brings it all back. */
async function byHand(page, link) {
  const { x, y } = await page.locator("#canvas").boundingBox();
  const at = () => page.evaluate(() => {
    const { view } = window.page;
    const { areas, middle, scale } = view.layout();
    return { area: areas[0], middle, scale, edge: view.edge, zoom: view.zoom, boxes: view.boxes.length };
  });
  const drag = async (from, to) => {
    await page.mouse.move(x + from[0], y + from[1]);
    await page.mouse.down();
    await page.mouse.move(x + to[0], y + to[1], { steps: 4 });
    await page.mouse.up();
  };
  const { area } = await at();
  const [left, top] = [area.left, area.top];
  const middle = top + area.height / 2;
  await drag([left + area.width / 2, middle], [left + area.width / 4, middle]);
  assert.ok(Math.abs((await at()).edge - 0.25) < 0.02, "the curtain follows");
  await page.check("#boxing");
  const hundredth = (part) => [left + area.width * part, top + area.height * part];
  await drag(hundredth(0.45), hundredth(0.5));
  await drag(hundredth(0.6), hundredth(0.8));
  await page.waitForFunction(() => /gCNR of the two boxes [01]\.\d{3}/.test(document.getElementById("measures").textContent));
  assert.equal((await at()).boxes, 2);
  await page.uncheck("#boxing");
  await page.mouse.move(x + left + area.width / 2, y + middle);
  await page.mouse.wheel(0, -400);
  await page.waitForFunction(() => window.page.view.zoom > 2);
  const zoomed = await at();
  await drag([left + area.width / 2, middle], [left + area.width / 2 + 50, middle + 20]);
  const panned = await at();
  assert.ok(Math.abs((zoomed.middle.x - panned.middle.x) * zoomed.scale - 50) < 1, "the picture follows");
  await page.focus("#canvas");
  await page.keyboard.press("0");
  assert.equal((await at()).zoom, 1);
  assert.equal(`#${new URLSearchParams(link.slice(1))}`, await page.evaluate(() => window.page.link()), "the link");
}

/** The gallery: each page below 2 MB, with a bone near the known surface where there is one. */
async function shown() {
  for (const file of gallery(program, built, join(folder, "gallery"))) {
    const name = basename(file, ".html");
    assert.ok(statSync(file).size < 2e6, `${file} has ${statSync(file).size} bytes`);
    const page = await tab(`file://${file}#bone=1`);
    assert.equal(await settled(page), "", name);
    const far = /distance to the known surface (\S+) mm/.exec(await page.textContent("#status"))?.[1];
    console.log(`${await page.textContent("#about")}${far ? `; bone ${far} mm from the known surface` : ""}`);
    assert.equal(far !== undefined, !["point", "picture"].includes(name), name);
    assert.ok(!(far > 0.5), `${name}: ${far} mm`);
    const [, found] = /Bone in (\d+) lines/.exec(await page.textContent("#status"));
    assert.ok(found >= ({ point: 0, picture: 100 }[name] ?? 10), `${name}: bone in ${found} lines`);
    if (name === "point") {
      await saved(page, "#save-recording", "point.npz");
      await results(page, { "beamform.method": "das" });
      const { point } = JSON.parse(hostSim("beamform", "point.npz", "--method", "das", "--json", "-o", "point-lines.npz"));
      await page.evaluate(({ x_m: x, z_m: z }) => { window.page.view.cursor = { x, z }; return window.page.read(); }, point);
      const widths = (await page.textContent("#measures")).match(/\d+\.\d+/g).map(Number);
      [point.width_6db_m, point.width_12db_m].forEach((width, k) => assert.ok(Math.abs(widths[k] - 1e3 * width) < 0.03, `${widths} mm, ${JSON.stringify(point)}`));
    }
    await page.screenshot({ path: at(`gallery-${name}.png`) });
    assert.deepEqual(page.wrong, []);
    await page.close();
  }
}

/** A page with frames, seen at three widths, dark and light: no fault of access, nothing beside the screen. */
async function looks(film) {
  const link = "#beamform.method=mv&B.beamform.method=das&show=curtain&bone=1";
  for (const [width, height, colorScheme] of [[390, 844, "light"], [1280, 900, "dark"], [2560, 1440, "light"]]) {
    const page = await tab(`file://${film}${link}`, { viewport: { width, height }, colorScheme });
    assert.equal(await settled(page), "");
    await page.evaluate(() => Object.assign(window.page.view, { cursor: { x: 0, z: 0.0155 }, boxes: [
      { x0: -2e-3, z0: 14.5e-3, x1: 2e-3, z1: 16e-3 }, { x0: -2e-3, z0: 18e-3, x1: 2e-3, z1: 22e-3 }] }));
    await page.focus("#canvas");
    await page.keyboard.press("ArrowRight");
    await page.waitForFunction(() => /width at .*gCNR/.test(document.getElementById("measures").textContent));
    assert.match(await page.textContent("#cursor"), /^x 0\.\d\d mm, depth 15\.\d\d mm: .* dB \| .* dB$/);
    const beyond = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(beyond <= 0, `${beyond} px beyond a screen of ${width}`);
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => axe.run());
    assert.deepEqual(violations.map(({ id, nodes }) => [id, nodes.map((node) => node.html)]), [], `axe at ${width} px`);
    await page.screenshot({ path: at(`curtain-${width}.png`), fullPage: width < 1000 });
    await byHand(page, link);
    // Controls of B leave A as it is.
    const hashes = () => page.evaluate(() => window.page.results.map((one) => one.image.hash));
    const [a, b] = await hashes();
    await page.click("input[name=which][value='1']");
    await page.selectOption("[id='beamform.method']", "esmv-rank1");
    assert.equal(await settled(page), "");
    const after = await hashes();
    assert.ok(after[0] === a && after[1] !== b, "B alone changes");
    // The film, by the keyboard.
    await page.selectOption("#shown", "both");
    assert.equal(await settled(page), "");
    await page.focus("#canvas");
    await page.keyboard.press(" ");
    await page.waitForFunction(() => Number(document.getElementById("frame-number").textContent) >= 2, null, { timeout: 60_000 });
    await page.keyboard.press(" ");
    assert.equal(await page.getAttribute("#play", "aria-pressed"), "false");
    await page.evaluate(() => new Promise((done) => setTimeout(done, 1000)));
    await page.screenshot({ path: at(`film-${width}.png`) });
    await saved(page, "#save-png", `saved-${width}.png`);
    assert.deepEqual(page.wrong, []);
    await page.close();
  }
}

const SMALL = `[simulate]
phantom = "vertebra"
[simulate.scanner]
elements = 32
beams = 32
fs = 20e6
depth_start = 10e-3
depth_end = 24e-3
noise = -40.0
`;
writeFileSync(at("small.toml"), SMALL);
const size = readFileSync(built).length;
assert.ok(size <= 2e6, `the page without a recording has ${size} bytes`);
console.log(hostSim("view", "--page", built, "-o", "page.html").trim());
const parts = {
  task,
  disk: () => fromDisk(at("page.html")),
  files,
  server: async () => assert.equal(await fromServer(at("page.html"), false), await fromServer(at("page.html"), true), "the image with shared memory"),
  speed,
  waves,
  gallery: shown,
  looks: async () => {
    writeFileSync(at("sweep.toml"), SMALL.replace("vertebra\"", "vertebra-3d\"\nsweep = 3\nthickness = 5e-4\n")
      + "element_height = 4e-3\nelevation_focus = 19e-3\n");
    hostSim("simulate", "--config", "sweep.toml", "-o", "sweep.npz");
    console.log(hostSim("view", "sweep.npz", "--page", built, "-o", "film.html").trim());
    await looks(at("film.html"));
  },
};
for (const name of argv[6]?.split(",") ?? Object.keys(parts)) await parts[name]();
await browser.close();
