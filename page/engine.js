// The workers, and what they compute.

/** @typedef {{rows: number, columns: number, x0: number, z0: number, pixel: number[], polar: boolean, hash: string,
 *   levels: Float32Array}} Picture */
/** @typedef {{image: Picture, map: Picture | null, points: number[][] | null, verdict: string, toml: string,
 *   warnings: string[], shape: any, coarse: boolean, seconds: number}} Result */

/** An error whose message is for people. */
class Refused extends Error {}

/** A result that a newer request has made useless. */
class Stale extends Error {}

/** @param {string} text */
function fromBase64(text) {
  const binary = atob(text.trim());
  const bytes = new Uint8Array(binary.length);
  for (let k = 0; k < binary.length; k += 1) bytes[k] = binary.charCodeAt(k);
  return bytes;
}

/** Unpacks gzip. @param {Uint8Array<ArrayBuffer>} bytes */
function unpacked(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** One worker, which does one thing at a time. */
class Hand {
  /** @param {string} address @param {WebAssembly.Module} module */
  constructor(address, module) {
    this.worker = new Worker(address);
    this.memory = 0;
    /** @type {Refused | null} */
    this.fault = null;
    /** @type {Promise<any>} */
    this.last = this.send({ module }, []);
    // A worker that nobody asks anything has no message.
    this.last.catch(() => {});
  }

  /** @param {any} message @param {Transferable[]} transfer */
  send(message, transfer) {
    if (this.fault) return Promise.reject(this.fault);
    return new Promise((resolve, reject) => {
      this.worker.onmessage = ({ data }) => resolve(data);
      this.worker.onerror = (event) => {
        event.preventDefault();
        this.fault = new Refused(WORDS.noWorker);
        reject(this.fault);
      };
      this.worker.postMessage(message, transfer);
    });
  }

  /**
   * Calls a function of the module, after the calls before it.
   * @param {string} name
   * @param {number[]} numbers
   * @param {string | ArrayBuffer | SharedArrayBuffer} [argument]
   * @param {Transferable[]} [transfer]
   * @returns {Promise<{json: any, bytes: ArrayBuffer}>}
   */
  call(name, numbers = [], argument = "", transfer = []) {
    const next = this.last.catch(() => {}).then(async () => {
      const answer = await this.send({ name, numbers, argument }, transfer);
      this.memory = answer.memory ?? 0;
      if (answer.failed === 2) throw new Refused(`${WORDS.ended} ${answer.text}`);
      if (answer.failed) throw new Refused(answer.text);
      return { json: JSON.parse(answer.text), bytes: answer.bytes };
    });
    this.last = next;
    return next;
  }
}

/** A recording or a picture in all workers. */
class Engine {
  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.module = module;
    const code = /** @type {HTMLElement} */ (document.getElementById("worker")).textContent ?? "";
    this.address = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
    /** @type {Hand[]} */
    this.hands = [];
    /** @type {any} */
    this.about = null;
    this.newest = 0;
    this.start();
  }

  start() {
    const count = Math.max(1, Math.min(navigator.hardwareConcurrency || 2, 8));
    this.hands.forEach((hand) => hand.worker.terminate());
    this.hands = Array.from({ length: count }, () => new Hand(this.address, this.module));
  }

  /** The first worker, which makes the pictures. */
  get first() {
    return this.hands[0];
  }

  /**
   * Opens a file in new workers.
   * @param {ArrayBuffer} bytes
   * @param {"open" | "picture"} how
   */
  async open(bytes, how) {
    this.newest += 1;
    this.start();
    let shared = bytes;
    if (self.crossOriginIsolated) {
      // Sent to each worker without a copy.
      const memory = new SharedArrayBuffer(bytes.byteLength);
      new Uint8Array(memory).set(new Uint8Array(bytes));
      shared = /** @type {any} */ (memory);
    }
    const opened = await this.first.call(how, [], shared);
    if (opened.json.kind === "channel") {
      await Promise.all(this.hands.slice(1).map((hand) => hand.call(how, [], shared)));
    }
    this.about = opened.json;
    return this.about;
  }

  /** Ends the computation of older requests. */
  supersede() {
    this.newest += 1;
    return this.newest;
  }

  /**
   * The pictures of a frame with settings.
   * @param {Object<string, string>} settings
   * @param {{frame: number, coarse: boolean, map: boolean, surface: boolean, request: number}} wanted
   * @returns {Promise<Result>}
   */
  async run(settings, { frame, coarse, map, surface, request }) {
    const begin = performance.now();
    const check = () => {
      if (request !== this.newest) throw new Stale();
    };
    const text = JSON.stringify(settings);
    const recorded = this.about.kind === "channel";
    const hands = recorded ? this.hands : [this.first];
    const [settled] = await Promise.all(hands.map((hand) => hand.call("settle", [Number(coarse)], text)));
    check();
    let z = new ArrayBuffer(0);
    let shape = null;
    if (recorded) {
      shape = (await this.first.call("shape")).json;
      z = await this.lines(shape, frame, coarse, check);
    }
    check();
    const image = picture(await this.first.call("image", [], z, [z]));
    check();
    const bones = map ? picture(await this.first.call("bone_map")) : null;
    check();
    const found = surface ? (await this.first.call("surface", [frame])).json : null;
    check();
    return {
      image,
      map: bones,
      points: found?.points ?? null,
      verdict: found?.verdict ?? "",
      toml: settled.json.toml,
      warnings: settled.json.warnings,
      shape,
      coarse,
      seconds: (performance.now() - begin) / 1000,
    };
  }

  /**
   * All lines of a frame, part by part: the next part goes to the worker that is free.
   * @param {any} shape
   * @param {number} frame
   * @param {boolean} coarse
   * @param {() => void} check
   */
  async lines(shape, frame, coarse, check) {
    const z = new Float32Array(2 * shape.lines * shape.samples);
    // Smaller parts end sooner for a newer request, and take less memory where records are upsampled.
    const parts = Math.min(shape.beams, this.hands.length * (coarse ? 1 : 3));
    let next = 0;
    const work = async (/** @type {Hand} */ hand) => {
      while (next < parts) {
        check();
        const own = next;
        next += 1;
        const { json, bytes } = await hand.call("part", [frame, own, parts]);
        z.set(new Float32Array(bytes), 2 * json.first * shape.samples);
      }
    };
    await Promise.all(this.hands.map(work));
    return z.buffer;
  }

  /** The largest memory of the workers' modules together, bytes. */
  memory() {
    return this.hands.reduce((sum, hand) => sum + hand.memory, 0);
  }
}

/** @param {{json: any, bytes: ArrayBuffer}} answer @returns {Picture} */
function picture({ json, bytes }) {
  return { ...json, levels: new Float32Array(bytes) };
}
