// Controls of all parameters, from their one description.

/** @typedef {{section: string, name: string, flag: string, heading: string, help: string, more: string, unit: string,
 *   choices: string[][], switch: boolean, list: boolean, type: string, range: number[] | null,
 *   replaces: string[]}} Key */

/** Keys that are seen first; the others are in the sections below. */
const FIRST = [
  "beamform.method", "beamform.beta", "beamform.temporal_half_window", "beamform.diagonal_loading",
  "beamform.subaperture_ratio", "beamform.f_number", "beamform.postfilter", "beamform.sub_lines",
  "beamform.depth_step", "beamform.sound_speed", "image.dynamic_range", "image.median", "image.pixel_size",
  "phase_symmetry.scales", "phase_symmetry.threshold",
];
const SECTIONS = { beamform: "Beamformer and delay", image: "Image", phase_symmetry: "Phase symmetry", surface: "Bone surface" };

/** The settings: flags' texts by key; a key that is not here has its default. */
class Controls {
  /**
   * @param {HTMLElement} place
   * @param {Key[]} keys
   * @param {any} defaults
   * @param {(final: boolean) => void} changed
   */
  constructor(place, keys, defaults, changed) {
    this.keys = keys;
    this.defaults = defaults;
    this.changed = changed;
    /** @type {Object<string, string>} */
    this.given = {};
    /** @type {Map<string, (text: string | undefined) => void>} */
    this.shown = new Map();
    const first = document.createElement("div");
    for (const name of FIRST) {
      const key = keys.find((one) => idOf(one) === name);
      if (key) first.append(this.control(key));
    }
    place.append(first);
    for (const [section, title] of Object.entries(SECTIONS)) {
      const details = document.createElement("details");
      const summary = document.createElement("summary");
      summary.textContent = title;
      details.append(summary);
      const rest = keys.filter((key) => key.section === section && !FIRST.includes(idOf(key)) && key.flag);
      details.append(...rest.map((key) => this.control(key)));
      place.append(details);
    }
  }

  /** The default of a key as text; empty if it is left to the program. @param {Key} key */
  usual(key) {
    return textOf(this.defaults[key.section]?.[key.name]);
  }

  /** Takes the user's text of a key. @param {Key} key @param {string} text @param {boolean} final */
  take(key, text, final) {
    if (text === this.usual(key)) delete this.given[idOf(key)];
    else this.given[idOf(key)] = text;
    for (const other of key.replaces) {
      const name = `${key.section}.${other}`;
      delete this.given[name];
      this.shown.get(name)?.(undefined);
    }
    this.changed(final);
  }

  /** Replaces all settings. @param {Object<string, string>} given */
  set(given) {
    this.given = { ...given };
    for (const [name, show] of this.shown) show(this.given[name]);
  }

  /** The given keys of complete settings. @param {any} settings */
  givenOf(settings) {
    /** @type {Object<string, string>} */
    const given = {};
    for (const key of this.keys) {
      const value = textOf(settings[key.section]?.[key.name]);
      if (value !== this.usual(key) && value !== "") given[idOf(key)] = value;
    }
    return given;
  }

  /** @param {Key} key */
  control(key) {
    const id = idOf(key);
    const box = document.createElement("div");
    box.className = "control";
    const label = document.createElement("label");
    label.htmlFor = id;
    label.textContent = titleOf(key);
    const help = document.createElement("p");
    help.id = `${id}.help`;
    help.textContent = key.help.replace(/`/g, "");
    help.title = key.more;
    const usual = this.usual(key);
    /** @type {HTMLInputElement | HTMLSelectElement} */
    let input;
    if (key.choices.length) {
      input = document.createElement("select");
      if (!usual) input.append(new Option(WORDS.none, ""));
      input.append(...key.choices.map(([name, about]) => {
        const option = new Option(name, name);
        option.title = about;
        return option;
      }));
    } else {
      input = document.createElement("input");
      input.type = key.switch ? "checkbox" : "text";
      input.placeholder = WORDS.none;
      input.autocomplete = "off";
      input.spellcheck = false;
      if (!key.switch) input.inputMode = isNumber(key) ? "decimal" : "text";
    }
    input.id = id;
    input.setAttribute("aria-describedby", help.id);
    const slider = this.slider(key, usual);
    const show = (/** @type {string | undefined} */ text) => {
      const value = text ?? usual;
      if (input instanceof HTMLInputElement && key.switch) input.checked = value === "true";
      else input.value = value;
      if (slider && value !== "") slider.value = String(slider.place(Number(value)));
    };
    const read = () => (input instanceof HTMLInputElement && key.switch ? String(input.checked) : input.value.trim());
    input.addEventListener("change", () => {
      const text = read();
      if (slider && text !== "") slider.value = String(slider.place(Number(text)));
      this.take(key, text === "" ? usual : text, true);
    });
    box.append(label, input);
    if (slider) {
      const drag = (/** @type {boolean} */ final) => {
        input.value = slider.text();
        this.take(key, input.value, final);
      };
      slider.addEventListener("input", () => drag(false));
      slider.addEventListener("change", () => drag(true));
      box.append(slider);
    }
    box.append(help);
    this.shown.set(id, show);
    show(undefined);
    return box;
  }

  /**
   * A slider around the default of a number, within its range: evenly for whole numbers and ranges that begin at 0, else by ratios.
   * @param {Key} key @param {string} usual
   */
  slider(key, usual) {
    const middle = Number(usual);
    if (!isNumber(key) || key.list || usual === "" || !key.range || !Number.isFinite(middle)) return null;
    const whole = key.type.startsWith("int");
    const [least, most] = key.range;
    const even = whole || least <= 0 || middle === 0;
    const low = even ? Math.max(least, 0) : Math.max(least, middle / 8);
    const high = Math.min(most, even ? Math.max(whole ? 8 : 1e-3, 4 * middle) : middle * 8);
    const slider = /** @type {HTMLInputElement & {place: (value: number) => number, text: () => string}} */ (
      document.createElement("input"));
    slider.type = "range";
    slider.setAttribute("aria-label", `${titleOf(key)}, slider`);
    if (whole) [slider.min, slider.max, slider.step] = [low, high, 1].map(String);
    // Ranges may leave out 0.
    else [slider.min, slider.max, slider.step] = [even ? "1" : "0", "100", "1"];
    slider.place = (value) => {
      if (whole) return value;
      return even ? (100 * (value - low)) / (high - low) : (100 * Math.log(value / low)) / Math.log(high / low);
    };
    slider.text = () => {
      const part = Number(slider.value) / 100;
      if (whole) return slider.value;
      const value = even ? low + part * (high - low) : low * (high / low) ** part;
      return String(Number(value.toPrecision(3)));
    };
    return slider;
  }
}

/** @param {Key} key */
function idOf(key) {
  return `${key.section}.${key.name}`;
}

/** @param {Key} key */
function titleOf(key) {
  const words = key.name.replace(/[_.]/g, " ");
  return words[0].toUpperCase() + words.slice(1);
}

/** @param {Key} key */
function isNumber(key) {
  return /^(int|float)( \| None)?$/.test(key.type);
}

/** A value of the configuration as a flag's text. @param {any} value @returns {string} */
function textOf(value) {
  if (value === undefined || value === null) return "";
  if (Array.isArray(value)) return value.join(",");
  if (typeof value !== "object") return String(value);
  if ("columns" in value) return `${value.rows}x${value.columns}`;
  return Object.values(value).flat().join(",");
}
