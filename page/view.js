// Pictures on a canvas: axes in mm, colour bar, cursor, boxes, curtain; zoom and pan.

/** @typedef {{result: Result, shown: "image" | "map", title: string, range: number}} Pane */
/** @typedef {{x0: number, z0: number, x1: number, z1: number}} Box */

const MARGIN = { left: 46, top: 26, right: 64, bottom: 34 };
/** How far above its place the known surface is drawn, m. */
const ABOVE = 1e-3;

class View {
  /** @param {HTMLCanvasElement} canvas @param {() => void} moved what follows a move of the cursor or a new box */
  constructor(canvas, moved) {
    this.canvas = canvas;
    this.moved = moved;
    /** @type {Pane[]} */
    this.panes = [];
    /** Whether the second pane lies over the first, from the curtain on. */
    this.curtain = false;
    this.edge = 0.5;
    /** @type {number[][][]} segments of the known surface, m */
    this.truth = [];
    /** @type {{x: number, z: number} | null} */
    this.cursor = null;
    /** @type {Box[]} */
    this.boxes = [];
    this.boxing = false;
    this.zoom = 1;
    /** @type {{x: number, z: number} | null} the middle of what is seen; the picture's if null */
    this.middle = null;
    /** @type {WeakMap<Float32Array, HTMLCanvasElement>} */
    this.bitmaps = new WeakMap();
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** Shows all of the picture. */
  fit() {
    this.zoom = 1;
    this.middle = null;
    this.draw();
  }

  /** The picture of a pane. @param {Pane} pane */
  picture(pane) {
    return pane.shown === "map" && pane.result.map ? pane.result.map : pane.result.image;
  }

  /** The grey picture as a canvas of its own pixels. @param {Picture} picture @param {boolean} scaled */
  bitmap(picture, scaled) {
    const known = this.bitmaps.get(picture.levels);
    if (known) return known;
    const { rows, columns, levels } = picture;
    const bitmap = document.createElement("canvas");
    bitmap.width = columns;
    bitmap.height = rows;
    const context = /** @type {CanvasRenderingContext2D} */ (bitmap.getContext("2d"));
    const data = context.createImageData(columns, rows);
    const grey = new Uint32Array(data.data.buffer);
    let most = 0;
    if (scaled) for (const level of levels) if (level > most) most = level;
    const scale = scaled && most > 0 ? 255 / most : 1;
    for (let k = 0; k < levels.length; k += 1) {
      grey[k] = 0xff000000 | (0x10101 * Math.min(255, Math.max(0, Math.round(scale * levels[k]))));
    }
    context.putImageData(data, 0, 0);
    this.bitmaps.set(picture.levels, bitmap);
    return bitmap;
  }

  /** Where the panes lie, and pixels per m. */
  layout() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const count = this.curtain ? 1 : Math.max(1, this.panes.length);
    // One below the other on a narrow screen.
    const [across, down] = width < 560 ? [1, count] : [count, 1];
    const areas = Array.from({ length: count }, (_, k) => ({
      left: (k % across) * (width / across) + MARGIN.left,
      top: (k % down) * (height / down) + MARGIN.top,
      width: Math.max(10, width / across - MARGIN.left - MARGIN.right),
      height: Math.max(10, height / down - MARGIN.top - MARGIN.bottom),
    }));
    const picture = this.panes.length ? this.picture(this.panes[0]) : null;
    const size = picture ? [picture.columns * picture.pixel[0], picture.rows * picture.pixel[1]] : [1, 1];
    const scale = this.zoom * Math.min(areas[0].width / size[0], areas[0].height / size[1]);
    const whole = picture ? { x: picture.x0 + size[0] / 2, z: picture.z0 + size[1] / 2 } : { x: 0, z: 0 };
    return { areas, scale, middle: this.middle ?? whole };
  }

  /** A position of the canvas in m. @param {number} px @param {number} py */
  position(px, py) {
    const { areas, scale, middle } = this.layout();
    const within = (/** @type {any} */ a) =>
      px < a.left + a.width + MARGIN.right && py < a.top + a.height + MARGIN.bottom;
    const area = areas.find(within) ?? areas[areas.length - 1];
    return {
      x: middle.x + (px - area.left - area.width / 2) / scale,
      z: middle.z + (py - area.top - area.height / 2) / scale,
    };
  }

  /** The level of a pane's picture at a position; null outside. @param {Pane} pane @param {number} x @param {number} z */
  level(pane, x, z) {
    const picture = this.picture(pane);
    const column = Math.round((x - picture.x0) / picture.pixel[0]);
    const row = Math.round((z - picture.z0) / picture.pixel[1]);
    if (column < 0 || row < 0 || column >= picture.columns || row >= picture.rows) return null;
    return picture.levels[row * picture.columns + column];
  }

  draw() {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    const context = canvas.getContext("2d");
    if (!context || !this.panes.length) return;
    context.scale(ratio, ratio);
    const style = getComputedStyle(canvas);
    const ink = style.color;
    context.fillStyle = style.backgroundColor;
    context.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    const { areas, scale, middle } = this.layout();
    context.font = "12px system-ui, sans-serif";
    areas.forEach((area, k) => {
      const at = (/** @type {number} */ x, /** @type {number} */ z) => [
        area.left + area.width / 2 + (x - middle.x) * scale,
        area.top + area.height / 2 + (z - middle.z) * scale,
      ];
      const parts = this.curtain && this.panes.length > 1 ? this.panes : [this.panes[k]];
      context.save();
      context.beginPath();
      context.rect(area.left, area.top, area.width, area.height);
      context.clip();
      context.fillStyle = "#000";
      context.fillRect(area.left, area.top, area.width, area.height);
      context.imageSmoothingEnabled = scale * this.picture(parts[0]).pixel[0] < 3;
      parts.forEach((pane, part) => {
        const edge = area.left + this.edge * area.width;
        context.save();
        if (parts.length > 1) {
          context.beginPath();
          context.rect(part ? edge : area.left, area.top, part ? area.left + area.width - edge : this.edge * area.width, area.height);
          context.clip();
        }
        this.drawPane(context, pane, at, scale);
        context.restore();
        if (part) line(context, [[edge, area.top], [edge, area.top + area.height]], "#ffd24a", 2);
      });
      this.marks(context, at, area);
      context.restore();
      this.frame(context, parts, area, at, ink);
    });
  }

  /**
   * @param {CanvasRenderingContext2D} context @param {Pane} pane
   * @param {(x: number, z: number) => number[]} at @param {number} scale
   */
  drawPane(context, pane, at, scale) {
    const picture = this.picture(pane);
    const [left, top] = at(picture.x0 - picture.pixel[0] / 2, picture.z0 - picture.pixel[1] / 2);
    const size = [picture.columns * picture.pixel[0] * scale, picture.rows * picture.pixel[1] * scale];
    context.drawImage(this.bitmap(picture, picture === pane.result.map), left, top, size[0], size[1]);
    context.beginPath();
    context.rect(left, top, size[0], size[1]);
    context.clip();
    for (const ends of this.truth) {
      line(context, ends.map(([x, z]) => at(x, z - ABOVE)), "#6ee7ff", 1.5, [2, 3]);
    }
    let piece = /** @type {number[][]} */ ([]);
    const points = pane.result.points ?? [];
    points.forEach((point, k) => {
      if (k && point[3] !== points[k - 1][3]) {
        line(context, piece, "#ff8a5c", 2);
        piece = [];
      }
      piece.push(at(point[0], point[1]));
    });
    line(context, piece, "#ff8a5c", 2);
  }

  /** Cursor and boxes. @param {CanvasRenderingContext2D} context @param {(x: number, z: number) => number[]} at @param {any} area */
  marks(context, at, area) {
    if (this.cursor) {
      const [x, z] = at(this.cursor.x, this.cursor.z);
      line(context, [[x, area.top], [x, area.top + area.height]], "#ffffff88", 1);
      line(context, [[area.left, z], [area.left + area.width, z]], "#ffffff88", 1);
    }
    this.boxes.forEach((box, k) => {
      const [[x, z], [x1, z1]] = [at(box.x0, box.z0), at(box.x1, box.z1)];
      context.strokeStyle = k ? "#b8f26b" : "#ffd24a";
      context.lineWidth = 2;
      context.strokeRect(x, z, x1 - x, z1 - z);
      context.fillStyle = context.strokeStyle;
      context.fillText(String(k + 1), Math.min(x, x1) + 4, Math.min(z, z1) + 13);
    });
  }

  /**
   * Title, axes and colour bar.
   * @param {CanvasRenderingContext2D} context @param {Pane[]} panes @param {any} area
   * @param {(x: number, z: number) => number[]} at @param {string} ink
   */
  frame(context, panes, area, at, ink) {
    context.strokeStyle = ink;
    context.fillStyle = ink;
    context.lineWidth = 1;
    context.strokeRect(area.left, area.top, area.width, area.height);
    context.textBaseline = "middle";
    context.textAlign = "left";
    const titles = panes.map((pane) => pane.title);
    context.fillText(titles[0], area.left, area.top - 12, area.width / panes.length);
    if (titles.length > 1) {
      context.textAlign = "right";
      context.fillText(titles[1], area.left + area.width, area.top - 12, area.width / 2);
    }
    const [x0, z0] = at(0, 0);
    const perMm = (at(1e-3, 0)[0] - x0);
    const step = tick(60 / perMm);
    const marks = (/** @type {number} */ from, /** @type {number} */ to) => {
      const all = [];
      for (let k = Math.ceil(from / step); k * step <= to; k += 1) all.push(k * step);
      return all;
    };
    context.textAlign = "center";
    for (const mm of marks((area.left - x0) / perMm, (area.left + area.width - x0) / perMm)) {
      const x = x0 + mm * perMm;
      line(context, [[x, area.top + area.height], [x, area.top + area.height + 4]], ink, 1);
      context.fillText(short(mm).replace("-", "−"), x, area.top + area.height + 13);
    }
    context.textAlign = "right";
    context.fillText("mm", area.left + area.width, area.top + area.height + 26);
    if (this.truth.length) {
      context.textAlign = "left";
      context.fillText(`┄ ${WORDS.truth}`, area.left, area.top + area.height + 26, area.width - 30);
    }
    context.textAlign = "right";
    for (const mm of marks((area.top - z0) / perMm, (area.top + area.height - z0) / perMm)) {
      const z = z0 + mm * perMm;
      line(context, [[area.left - 4, z], [area.left, z]], ink, 1);
      context.fillText(short(mm).replace("-", "−"), area.left - 7, z);
    }
    const bar = { x: area.left + area.width + 10, width: 10 };
    const shades = context.createLinearGradient(0, area.top, 0, area.top + area.height);
    shades.addColorStop(0, "#fff");
    shades.addColorStop(1, "#000");
    context.fillStyle = shades;
    context.fillRect(bar.x, area.top, bar.width, area.height);
    context.strokeRect(bar.x, area.top, bar.width, area.height);
    context.fillStyle = ink;
    context.textAlign = "left";
    const map = panes[0].shown === "map";
    for (let k = 0; k <= 4; k += 1) {
      const text = map ? short(1 - k / 4) : `${short((-panes[0].range * k) / 4)}${k ? "" : " dB"}`;
      context.fillText(text.replace("-", "−"), bar.x + bar.width + 3, area.top + (area.height * k) / 4);
    }
  }

  listen() {
    const { canvas } = this;
    /** @type {{x: number, y: number, middle: {x: number, z: number}, what: "pan" | "box" | "curtain"} | null} */
    let held = null;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.magnify(Math.exp(-event.deltaY / 400), event.offsetX, event.offsetY);
    }, { passive: false });
    canvas.addEventListener("dblclick", () => this.fit());
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.panes.length) return;
      canvas.setPointerCapture(event.pointerId);
      const { middle, areas } = this.layout();
      const edge = areas[0].left + this.edge * areas[0].width;
      const near = this.curtain && Math.abs(event.offsetX - edge) < 12;
      held = { x: event.offsetX, y: event.offsetY, middle, what: near ? "curtain" : this.boxing ? "box" : "pan" };
      if (held.what === "box") {
        const { x, z } = this.position(event.offsetX, event.offsetY);
        this.boxes = [...this.boxes.slice(this.boxes.length > 1 ? 2 : 0), { x0: x, z0: z, x1: x, z1: z }];
      }
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held || !this.panes.length) return;
      const { scale, areas } = this.layout();
      if (held.what === "curtain") {
        this.edge = Math.min(1, Math.max(0, (event.offsetX - areas[0].left) / areas[0].width));
      } else if (held.what === "box") {
        const { x, z } = this.position(event.offsetX, event.offsetY);
        Object.assign(this.boxes[this.boxes.length - 1], { x1: x, z1: z });
      } else {
        this.middle = {
          x: held.middle.x - (event.offsetX - held.x) / scale,
          z: held.middle.z - (event.offsetY - held.y) / scale,
        };
      }
      this.draw();
    });
    canvas.addEventListener("pointerup", (event) => {
      const still = held && Math.hypot(event.offsetX - held.x, event.offsetY - held.y) < 4;
      if (held?.what === "pan" && still) {
        this.middle = this.zoom === 1 ? null : held.middle;
        const { x, z } = this.position(event.offsetX, event.offsetY);
        this.cursor = { x, z };
      }
      held = null;
      this.draw();
      this.moved();
    });
  }

  /** Zooms about a position of the canvas. @param {number} by @param {number} [px] @param {number} [py] */
  magnify(by, px, py) {
    if (!this.panes.length) return;
    const { areas, middle } = this.layout();
    const about = px === undefined || py === undefined ? middle : this.position(px, py);
    const zoom = Math.min(50, Math.max(1, this.zoom * by));
    const kept = this.zoom / zoom;
    this.zoom = zoom;
    this.middle = zoom === 1 ? null : { x: about.x + (middle.x - about.x) * kept, z: about.z + (middle.z - about.z) * kept };
    if (areas.length) this.draw();
  }

  /** Moves the cursor by pixels of the picture. @param {number} right @param {number} down */
  step(right, down) {
    if (!this.panes.length) return;
    const picture = this.picture(this.panes[0]);
    const { middle } = this.layout();
    const from = this.cursor ?? middle;
    this.cursor = { x: from.x + right * picture.pixel[0], z: from.z + down * picture.pixel[1] };
    this.draw();
    this.moved();
  }
}

/** @param {CanvasRenderingContext2D} context @param {number[][]} points @param {string} colour @param {number} width @param {number[]} [dashes] */
function line(context, points, colour, width, dashes = []) {
  context.beginPath();
  points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dashes);
  context.stroke();
  context.setLineDash([]);
}

/** 1, 2 or 5 times a power of ten, at least so much. @param {number} least */
function tick(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 5, 10].find((by) => by * power >= least) ?? 10);
}
