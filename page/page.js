// The page: files, settings, requests, and what follows them.

/** An element of any kind. @param {string} id @returns {any} */
function part(id) {
  return document.getElementById(id);
}

const MOST = 256 * 2 ** 20;

class Page {
  /** @param {Engine} engine @param {{keys: Key[], defaults: any}} described @param {any} extra */
  constructor(engine, described, extra) {
    this.engine = engine;
    this.extra = extra;
    this.name = extra.name ?? "recording.npz";
    /** @type {ArrayBuffer | null} */
    this.bytes = null;
    this.frame = 0;
    this.which = 0;
    this.playing = false;
    /** Settings A and B. @type {Object<string, string>[]} */
    this.settings = [{}, {}];
    /** @type {(Result | null)[]} */
    this.results = [null, null];
    /** A marker of the newest request; tests wait for its end. */
    this.done = Promise.resolve();
    this.controls = new Controls(part("controls"), described.keys, described.defaults, (final) => {
      this.settings[this.which] = { ...this.controls.given };
      this.results[this.which] = null;
      this.update(!final);
    });
    this.view = new View(part("canvas"), () => void this.read());
    this.listen();
  }

  /** @type {HTMLSelectElement} */
  get shown() {
    return part("shown");
  }

  /** Whether A and B are both shown. */
  get two() {
    return this.shown.value === "beside" || this.shown.value === "curtain";
  }

  /** @param {string} text */
  say(text) {
    part("message").textContent = text;
  }

  /** Opens a file of any kind. @param {ArrayBuffer} bytes @param {string} name */
  async open(bytes, name) {
    this.say("");
    try {
      if (bytes.byteLength > MOST) throw new Refused(WORDS.tooLarge(name, bytes.byteLength));
      const head = new Uint8Array(bytes, 0, Math.min(4, bytes.byteLength));
      const begins = (/** @type {number[]} */ own) => own.every((byte, k) => head[k] === byte);
      if (/\.toml$/i.test(name)) {
        const text = new TextDecoder().decode(bytes);
        const { json } = await this.engine.first.call("read_toml", [], text);
        this.use(this.controls.givenOf(json));
        return;
      }
      const archive = begins([0x50, 0x4b]);
      const jpeg = begins([0xff, 0xd8]);
      if (!archive && !jpeg && !begins([0x89, 0x50, 0x4e, 0x47])) throw new Refused(WORDS.otherFile(name));
      this.stop();
      const sent = jpeg ? await asPng(bytes) : bytes;
      const about = await this.engine.open(sent, archive ? "open" : "picture");
      if (about.kind === "aligned") throw new Refused(WORDS.aligned);
      this.bytes = archive ? bytes : null;
      this.name = name;
      this.results = [null, null];
      this.frame = 0;
      this.view.truth = name === this.extra.name ? (this.extra.truth ?? []) : [];
      this.view.boxes = [];
      this.view.cursor = null;
      part("about").textContent = `${name}: ${WORDS[/** @type {"channel"} */ (about.kind)](about)}`;
      part("film").hidden = about.frames < 2 || about.kind !== "channel";
      part("frame").setAttribute("max", String(about.frames - 1));
      if (about.kind === "picture") {
        this.use({ "image.pixel_size": "0.0001", ...this.settings[this.which] });
        part("bone").checked = true;
      }
      this.view.fit();
      this.update(false);
    } catch (error) {
      this.fail(error);
    }
    await this.done;
  }

  /** Takes settings as those of A or B. @param {Object<string, string>} given */
  use(given) {
    this.settings[this.which] = given;
    this.results[this.which] = null;
    this.controls.set(given);
    this.update(false);
  }

  /** @param {unknown} error */
  fail(error) {
    if (error instanceof Stale) return;
    if (!(error instanceof Refused)) throw error;
    this.say(error.message);
  }

  /** Computes what is shown and not yet known, first coarse. @param {boolean} dragging */
  update(dragging) {
    if (!this.engine.about) return;
    const request = this.engine.supersede();
    this.done = this.refresh(request, dragging).catch((error) => this.fail(error));
  }

  /** @param {number} request @param {boolean} dragging */
  async refresh(request, dragging) {
    const sides = this.two ? [0, 1] : [this.which];
    const wanted = { frame: this.frame, request, map: this.shown.value === "map" || this.shown.value === "both" };
    const bone = part("bone").checked;
    const coarse = this.engine.about.kind === "channel";
    for (const side of sides) {
      if (this.complete(this.results[side], wanted.map, bone)) continue;
      if (coarse) {
        this.results[side] = await this.engine.run(this.settings[side], { ...wanted, coarse: true, surface: false });
        this.show(sides);
      }
      if (dragging) continue;
      this.results[side] = await this.engine.run(this.settings[side], { ...wanted, coarse: false, surface: bone });
      this.say("");
      this.show(sides);
    }
    this.show(sides);
  }

  /** @param {Result | null} result @param {boolean} map @param {boolean} bone */
  complete(result, map, bone) {
    return result && !result.coarse && (!map || result.map) && (!bone || result.points);
  }

  /** Draws the results. @param {number[]} sides */
  show(sides) {
    const named = (/** @type {number} */ side, /** @type {"image" | "map"} */ shown) => {
      const given = this.settings[side];
      const words = Object.entries(given).map(([key, text]) => `${key.split(".")[1]} ${text}`);
      const method = given["beamform.method"] ?? textOf(this.controls.defaults.beamform.method);
      const others = words.filter((word) => !word.startsWith("method "));
      return `${this.two ? `${"AB"[side]}: ` : ""}${WORDS[shown]}, ${[method, ...others].join(", ")}`;
    };
    const pane = (/** @type {number} */ side, /** @type {"image" | "map"} */ shown) => {
      const result = this.results[side];
      const range = Number(this.settings[side]["image.dynamic_range"] ?? this.controls.defaults.image.dynamic_range);
      return result ? [{ result, shown, range, title: named(side, shown) }] : [];
    };
    const shown = this.shown.value;
    if (shown === "both") this.view.panes = [...pane(sides[0], "image"), ...pane(sides[0], "map")];
    else if (this.two) this.view.panes = sides.flatMap((side) => pane(side, "image"));
    else this.view.panes = pane(sides[0], shown === "map" ? "map" : "image");
    this.view.curtain = shown === "curtain";
    this.view.draw();
    const result = this.results[this.which] ?? this.results[sides[0]];
    if (!result) return;
    part("canvas").setAttribute("aria-label", WORDS.described(this.view.panes.map((one) => one.title).join("; ")));
    part("status").textContent =
      WORDS.shape(result.shape) + WORDS.computed(result.seconds, result.coarse) + this.boneWords(result) + result.warnings.join(" ");
    part("hashes").textContent = result.coarse ? "…" : WORDS.hashes(result.image.hash, result.map?.hash ?? "");
    const recorded = this.engine.about.kind === "channel" && this.bytes !== null;
    part("command").hidden = !recorded;
    part("command-words").textContent = WORDS.command;
    part("command-line").textContent =
      `host-sim beamform ${this.name} --config settings.toml${this.engine.about.frames > 1 ? ` --frames ${this.frame}` : ""} ` +
      "-o lines.npz --image image.npy --bone-map map.npy";
    for (const id of ["save-toml", "save-png", "copy-link"]) part(id).disabled = false;
    part("save-recording").disabled = this.bytes === null;
    void this.read();
  }

  /** @param {Result} result */
  boneWords(result) {
    if (!result.points) return "";
    const far = distance(result.points, this.view.truth);
    return `${WORDS.bone(result.points.length)} ${result.verdict} ${far === null ? "" : WORDS.distance(1e3 * far)} `;
  }

  /** The values at the cursor, its profile and the boxes. */
  async read() {
    const pane = this.view.panes[0];
    const cursor = this.view.cursor;
    if (!pane) return;
    if (cursor) {
      const values = this.view.panes.map((one) => {
        const level = this.view.level(one, cursor.x, cursor.z);
        if (level === null) return WORDS.outside;
        return one.shown === "map" ? short(level) : `${((level / 255 - 1) * one.range).toFixed(1)} dB`;
      });
      part("cursor").textContent = WORDS.cursor(1e3 * cursor.x, 1e3 * cursor.z, values.join(" | ")).replace(/-/g, "−");
    } else {
      part("cursor").textContent = "";
    }
    const words = [];
    const profiles = cursor ? this.view.panes.filter((one) => one.shown === "image").map((one) => row(one, cursor)) : [];
    drawProfiles(part("profile"), profiles, pane.range);
    for (const profile of profiles) {
      if (!profile || profile.near.length < 3) continue;
      const request = JSON.stringify({ profile: { step: profile.step, db: profile.near } });
      const { json } = await this.engine.first.call("measure", [], request);
      const mm = (/** @type {number | null} */ width) => (width === null ? "–" : `${(1e3 * width).toFixed(2)} mm`);
      words.push(WORDS.widths(mm(json.width_6db), mm(json.width_12db)));
    }
    if (this.view.boxes.length === 2) {
      const [a, b] = this.view.boxes.map((box) => levelsOf(this.view.picture(pane), box));
      const { json } = await this.engine.first.call("measure", [], JSON.stringify({ regions: { a, b } }));
      words.push(WORDS.gcnr(json.gcnr === null ? "–" : json.gcnr.toFixed(3)));
    } else if (this.view.boxing) {
      words.push(WORDS.boxes);
    }
    part("measures").textContent = words.join("; ");
  }

  /** The settings as the fragment of a link. */
  link() {
    const words = new URLSearchParams(this.settings[0]);
    for (const [key, text] of Object.entries(this.settings[1])) words.set(`B.${key}`, text);
    words.set("show", this.shown.value);
    if (part("bone").checked) words.set("bone", "1");
    if (this.frame) words.set("frame", String(this.frame));
    return `#${words}`;
  }

  /** Takes the settings of the address. */
  readLink() {
    const words = new URLSearchParams(location.hash.slice(1));
    const known = new Set(this.controls.keys.map(idOf));
    for (const [key, text] of words) {
      if (known.has(key)) this.settings[0][key] = text;
      else if (key.startsWith("B.") && known.has(key.slice(2))) this.settings[1][key.slice(2)] = text;
    }
    const shown = words.get("show");
    if (shown && [...this.shown.options].some((option) => option.value === shown)) this.shown.value = shown;
    part("bone").checked = words.get("bone") === "1";
    this.frame = Number(words.get("frame")) || 0;
    part("which").hidden = !this.two;
    this.controls.set(this.settings[0]);
  }

  /** Another frame, whole. @param {number} frame */
  async showFrame(frame) {
    this.frame = Math.min(Math.max(0, frame), this.engine.about.frames - 1);
    part("frame").value = String(this.frame);
    part("frame-number").textContent = String(this.frame);
    const request = this.engine.supersede();
    this.results = [null, null];
    for (const side of this.two ? [0, 1] : [this.which]) {
      this.results[side] = await this.engine.run(this.settings[side], {
        frame: this.frame, request, coarse: false, map: this.shown.value === "map" || this.shown.value === "both",
        surface: part("bone").checked,
      });
    }
    this.show(this.two ? [0, 1] : [this.which]);
  }

  stop() {
    this.playing = false;
    part("play").setAttribute("aria-pressed", "false");
    part("play").textContent = "Play";
  }

  async play() {
    if (this.playing) return this.stop();
    this.playing = true;
    part("play").setAttribute("aria-pressed", "true");
    part("play").textContent = "Pause";
    try {
      // At most 25 frames a second.
      while (this.playing) {
        const next = new Promise((resolve) => setTimeout(resolve, 40));
        await this.showFrame((this.frame + 1) % this.engine.about.frames);
        await next;
      }
    } catch (error) {
      this.stop();
      this.fail(error);
    }
  }

  listen() {
    this.shown.addEventListener("change", () => {
      part("which").hidden = !this.two;
      this.update(false);
    });
    for (const input of document.querySelectorAll("input[name=which]")) {
      input.addEventListener("change", () => {
        this.which = Number(/** @type {HTMLInputElement} */ (input).value);
        this.controls.set(this.settings[this.which]);
      });
    }
    part("bone").addEventListener("change", () => this.update(false));
    part("boxing").addEventListener("change", () => {
      this.view.boxing = part("boxing").checked;
      this.view.boxes = [];
      this.view.draw();
      void this.read();
    });
    part("fit").addEventListener("click", () => this.view.fit());
    part("play").addEventListener("click", () => void this.play());
    part("frame").addEventListener("input", () => {
      this.stop();
      this.done = this.showFrame(Number(part("frame").value)).catch((error) => this.fail(error));
    });
    part("canvas").addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
      const by = event.shiftKey ? 10 : 1;
      /** @type {Object<string, () => void>} */
      const keys = {
        ArrowLeft: () => this.view.step(-by, 0), ArrowRight: () => this.view.step(by, 0),
        ArrowUp: () => this.view.step(0, -by), ArrowDown: () => this.view.step(0, by),
        "+": () => this.view.magnify(1.25), "-": () => this.view.magnify(0.8), 0: () => this.view.fit(),
        " ": () => { if (!part("film").hidden) void this.play(); },
      };
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
    const file = part("file");
    file.addEventListener("change", async () => {
      const own = file.files?.[0];
      file.value = "";
      if (own) await this.open(await own.arrayBuffer(), own.name);
    });
    const drop = part("drop");
    drop.textContent = WORDS.dropped;
    addEventListener("dragover", (event) => {
      event.preventDefault();
      drop.hidden = false;
    });
    addEventListener("dragleave", (event) => { if (!event.relatedTarget) drop.hidden = true; });
    addEventListener("drop", async (event) => {
      event.preventDefault();
      drop.hidden = true;
      const own = event.dataTransfer?.files[0];
      if (own) await this.open(await own.arrayBuffer(), own.name);
    });
    part("save-toml").addEventListener("click", () => {
      const toml = this.results[this.which]?.toml;
      if (toml) save(new Blob([toml]), "settings.toml");
    });
    part("save-recording").addEventListener("click", () => { if (this.bytes) save(new Blob([this.bytes]), this.name); });
    part("save-png").addEventListener("click", () => part("canvas").toBlob((/** @type {Blob} */ png) => save(png, "bone.png")));
    part("copy-link").addEventListener("click", async () => {
      const link = this.link();
      location.hash = link;
      await navigator.clipboard?.writeText(location.href).catch(() => {});
    });
  }
}

/** The row of a pane's image through the cursor, dB, and its part within 3 mm. @param {Pane} pane @param {{x: number, z: number}} at */
function row(pane, at) {
  const picture = pane.result.image;
  const index = Math.round((at.z - picture.z0) / picture.pixel[1]);
  if (index < 0 || index >= picture.rows) return null;
  const own = picture.levels.subarray(index * picture.columns, (index + 1) * picture.columns);
  const db = Array.from(own, (level) => (level / 255 - 1) * pane.range);
  const column = Math.round((at.x - picture.x0) / picture.pixel[0]);
  const reach = Math.round(3e-3 / picture.pixel[0]);
  const near = db.slice(Math.max(0, column - reach), Math.max(0, column + reach + 1));
  return { db, near, step: picture.pixel[0], x0: picture.x0, x: at.x };
}

/** @param {HTMLCanvasElement} canvas @param {(ReturnType<typeof row>)[]} profiles @param {number} range */
function drawProfiles(canvas, profiles, range) {
  const ratio = window.devicePixelRatio || 1;
  canvas.hidden = !profiles.length;
  const { clientWidth: width, clientHeight: height } = canvas;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.setAttribute("aria-label", WORDS.profile);
  const context = canvas.getContext("2d");
  const known = profiles.find((profile) => profile);
  if (!context || !known) return;
  context.scale(ratio, ratio);
  const ink = getComputedStyle(canvas).color;
  const [left, right, top, bottom] = [46, 12, 8, 22];
  const long = known.step * (known.db.length - 1);
  const x = (/** @type {number} */ m) => left + ((m - known.x0) / long) * (width - left - right);
  const y = (/** @type {number} */ db) => top + (-db / range) * (height - top - bottom);
  context.font = "12px system-ui, sans-serif";
  context.fillStyle = ink;
  context.textBaseline = "middle";
  context.textAlign = "right";
  for (const db of [0, -range / 2, -range]) {
    context.fillText(short(db).replace("-", "−"), left - 6, y(db));
    line(context, [[left, y(db)], [width - right, y(db)]], ink, 0.3);
  }
  context.textAlign = "center";
  const step = tick((1e3 * long) / 8);
  for (let k = Math.ceil((1e3 * known.x0) / step); k * step <= 1e3 * (known.x0 + long); k += 1) {
    context.fillText(short(k * step).replace("-", "−"), x((k * step) / 1e3), height - 9);
  }
  profiles.forEach((profile, k) => {
    if (profile) line(context, profile.db.map((db, n) => [x(profile.x0 + n * profile.step), y(db)]), ["#2f81f7", "#e8590c"][k], 1.5);
  });
  line(context, [[x(known.x), top], [x(known.x), height - bottom]], ink, 1, [3, 3]);
}

/** The levels of a picture in a box. @param {Picture} picture @param {Box} box */
function levelsOf(picture, box) {
  const index = (/** @type {number} */ at, /** @type {number} */ from, /** @type {number} */ step, /** @type {number} */ count) =>
    Math.min(count, Math.max(0, Math.round((at - from) / step)));
  const columns = [box.x0, box.x1].map((x) => index(x, picture.x0, picture.pixel[0], picture.columns)).sort((a, b) => a - b);
  const rows = [box.z0, box.z1].map((z) => index(z, picture.z0, picture.pixel[1], picture.rows)).sort((a, b) => a - b);
  const levels = [];
  for (let r = rows[0]; r < rows[1]; r += 1) {
    for (let c = columns[0]; c < columns[1]; c += 1) levels.push(picture.levels[r * picture.columns + c]);
  }
  return levels;
}

/** Mean distance of points to the nearest segment, m; null without either. @param {number[][]} points @param {number[][][]} segments */
function distance(points, segments) {
  if (!points.length || !segments.length) return null;
  const far = (/** @type {number[]} */ [x, z]) => Math.min(...segments.map(([[ax, az], [bx, bz]]) => {
    const [dx, dz] = [bx - ax, bz - az];
    const along = Math.min(1, Math.max(0, ((x - ax) * dx + (z - az) * dz) / (dx * dx + dz * dz || 1)));
    return Math.hypot(ax + along * dx - x, az + along * dz - z);
  }));
  return points.reduce((sum, point) => sum + far(point), 0) / points.length;
}

/** A picture of another format as a PNG. @param {ArrayBuffer} bytes */
async function asPng(bytes) {
  const image = await createImageBitmap(new Blob([bytes]), { colorSpaceConversion: "none" }).catch(() => {
    throw new Refused(WORDS.otherFile("The picture"));
  });
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [image.width, image.height];
  canvas.getContext("2d")?.drawImage(image, 0, 0);
  const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  return /** @type {Blob} */ (blob).arrayBuffer();
}

/** @param {Blob} blob @param {string} name */
function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

async function main() {
  part("about").textContent = WORDS.drop;
  const wasm = await unpacked(fromBase64(part("wasm").textContent ?? ""));
  let module;
  try {
    module = await WebAssembly.compile(wasm);
  } catch {
    throw new Refused(WORDS.noSimd);
  }
  const engine = new Engine(module);
  const { json: described } = await engine.first.call("describe");
  const extra = JSON.parse(part("extra").textContent ?? "{}");
  const page = new Page(engine, described, extra);
  Object.assign(window, { page });
  if (extra.toml) {
    const { json } = await engine.first.call("read_toml", [], extra.toml);
    page.settings[0] = page.controls.givenOf(json);
  }
  page.readLink();
  const own = part("recording").textContent?.trim() ?? "";
  if (own) await page.open(await unpacked(fromBase64(own)), page.name);
  else part("status").textContent = WORDS.empty;
}

main().catch((error) => {
  part("message").textContent = error instanceof Refused ? error.message : String(error);
  part("status").textContent = "";
});
