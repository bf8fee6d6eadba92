/**
 * The controls at the side, made of what the server says of each parameter.
 *
 * @import {App} from "./app.js"
 * @import {Model, Parameter, Preset, State} from "./types.js"
 * @import {Player} from "./player.js"
 */
import { element, iconButton, playButton, write } from "./dom.js";
import {
  FORMULA,
  blockCount,
  continuousParameters,
  defaultLaw,
  defaultModel,
  hasLaws,
  hasLineMap,
  hasMatrices,
  isFormula,
  kindEntry,
  lawOf,
  lawsOf,
  isStructure,
  mapOf,
  parametersOf,
  shapeOf,
  startPoint,
  startState,
  sticksAsOne,
  valueOf,
  whatRubs,
  withForcing,
  withFormula,
  withLaw,
  withLaws,
} from "./model.js";
import { spelled, unquoted, within, written } from "./numbers.js";
import { clean, completeAlong, completeState, same } from "./state.js";

export class Controls {
  /** @param {App} app @param {Preset[]} presets @param {Player} player @param {HTMLElement} host */
  constructor(app, presets, player, host) {
    this.app = app;
    this.player = player;
    this.presets = presets;
    /** @type {((state: State) => void)[]} */ this.fixed = [];
    /** @type {((state: State) => void)[]} */ this.changing = [];
    this.shape = "";
    this.system = "";
    /** @type {Record<string, true>} */ this.kept = {};
    this.error = element("p", { class: "error", role: "alert", hidden: true });
    this.typed = { fields: /** @type {string[]} */ ([]), message: "" }; // wrong before it is asked
    this.told = this.typed; // by the server
    this.modelRows = element("div", {});
    this.lawRows = element("div", {});
    this.lawHost = element("div", { class: "law-host" });
    host.append(
      this.#preset(),
      this.#model(),
      this.#law(),
      this.#map(),
      this.#along(),
      this.#motion(),
      this.error,
    );
    app.store.subscribe((state, learned) => this.sync(state, learned));
    app.showError = (fields, message) => {
      this.told = { fields, message };
      this.#mark();
    };
    app.showTime = (t) => (this.time.textContent = t.toFixed(1));
    this.sync(app.state);
  }

  /** @param {State} state @param {boolean} [learned]  what was typed wrong stands until something changes */
  sync(state, learned = false) {
    if (!learned) this.mark(null, "");
    const { model } = state;
    const laws = lawsOf(model).map(({ law }) => law);
    const shape = [
      ...[model.kind, laws, hasLaws(model), Boolean(model.forcing)],
      JSON.stringify(state.sliders),
      ...this.#listed(state).ofModel.map(({ name }) => name),
    ].join(" ");
    if (shape !== this.shape) this.#rebuild(state);
    this.shape = shape;
    for (const show of [...this.fixed, ...this.changing]) show(state);
  }

  /** Numbers of this system, those too that have been set to 0 meanwhile. @param {State} state */
  #listed(state) {
    const system = shapeOf(state);
    if (system !== this.system) this.kept = {};
    this.system = system;
    const listed = parametersOf(this.app.limits, state.model, { ...state.sliders, ...this.kept });
    for (const { name } of listed.ofModel) this.kept[name] = true;
    return listed;
  }

  /** Rows for the parameters of this kind and this law. @param {State} state */
  #rebuild(state) {
    const { limits } = this.app;
    this.changing = [];
    const { sliders } = state;
    const { ofModel, ofLaws } = this.#listed(state);
    const ranged = (/** @type {Parameter} */ one) => {
      const [min, max] = sliders[one.name] ?? [one.min, one.max];
      return { ...one, min, max, ...(one.name in sliders ? stepOf(min, max) : {}) };
    };
    const row = (/** @type {Parameter} */ one) => this.#parameter(ranged(one));
    const held = document.activeElement?.getAttribute("aria-label");
    const listed = hasMatrices(state.model) ? ofModel.filter((one) => one.name in sliders) : ofModel;
    const rest = ofModel.filter((one) => !listed.includes(one));
    const more = element("details", {}, element("summary", {}, "All other numbers"));
    more.append(...rest.map(row));
    this.modelRows.replaceChildren(...listed.map(row), ...(rest.length ? [more] : []));
    this.lawRows.replaceChildren(
      ...ofLaws.flatMap((ofLaw, block) => [
        ...this.#lawOf(block, hasLaws(state.model)),
        ...ofLaw.map(row),
      ]),
    );
    const again = held && `[aria-label="${CSS.escape(held)}"]`;
    for (const rows of [this.modelRows, this.lawRows])
      if (again) /** @type {HTMLElement | null} */ (rows.querySelector(again))?.focus();
    const options = continuousParameters(limits, state.model, this.kept).map((one) =>
      element("option", { value: one.name }, `${written(one.symbol)}, ${one.meaning}`),
    );
    this.along.replaceChildren(...options);
  }

  // --- rows ------------------------------------------------------------------------------------

  /** @param {Parameter} one */
  #parameter(one) {
    const get = (/** @type {State} */ state) => valueOf(this.app.limits, state.model, one.name);
    const set = (/** @type {any} */ value) => this.app.setParameter(one.name, value);
    if (one.values) return this.#choice(one, get, set);
    return one.per_block
      ? this.#list(one, get, set, this.changing)
      : this.#number(one, get, set, this.changing);
  }

  /**
   * Symbol, slider, typed value.
   * @param {Parameter & {whole?: boolean}} one
   * @param {(state: State) => number} get
   * @param {(value: number) => void} set
   * @param {((state: State) => void)[]} shows
   */
  #number(one, get, set, shows) {
    const label = `${one.meaning} ${written(one.symbol)}`;
    const slider = sliderOf(one, label, set);
    const typed = element("input", {
      type: "number",
      step: one.whole ? 1 : "any",
      "aria-label": label,
      name: one.name,
      onchange: () => {
        const value = typed.valueAsNumber;
        const whole =
          !one.whole || (Number.isInteger(value) && value >= one.min && value <= one.max);
        const allowed = one.whole ? "must be a whole number" : "must be a number; its slider goes";
        if (!Number.isFinite(value) || !whole)
          return this.mark(one.name, `${label} ${allowed} from ${within(one.min, one.max).join(" to ")}.`);
        set(value);
      },
    });
    shows.push((state) => {
      const value = get(state);
      slider.show(value);
      if (typed.valueAsNumber !== value || typed.value === "") write(typed, String(value));
    });
    const word = element("span", { class: "word", "aria-hidden": "true" }, one.meaning);
    return element(
      "div",
      { class: "row worded", title: one.meaning },
      symbolOf(one),
      word,
      slider.input,
      typed,
    );
  }

  /**
   * One of a few values.
   * @param {Parameter} one
   * @param {(state: State) => number} get
   * @param {(value: number) => void} set
   */
  #choice(one, get, set) {
    const options = (one.values ?? []).map((value) => element("option", { value }, String(value)));
    const made = element(
      "select",
      { "aria-label": one.meaning, name: one.name, onchange: () => set(Number(made.value)) },
      ...options,
    );
    this.changing.push((state) => (made.value = String(get(state))));
    return element("div", { class: "row wide", title: one.meaning }, symbolOf(one), made);
  }

  /**
   * Several numbers in one field.
   * @param {Parameter} one
   * @param {(state: State) => number[]} get
   * @param {(value: number[]) => void} set
   * @param {((state: State) => void)[]} shows
   * @param {(state: State) => {min: number, max: number}} [counts]  how many; by default as many as there may be blocks
   */
  #list(
    one,
    get,
    set,
    shows,
    counts = ({ model }) => kindEntry(this.app.limits, model.kind).blocks ?? { min: 1, max: 8 },
  ) {
    const field = element("input", {
      type: "text",
      "aria-label": `${one.meaning}, numbers with commas`,
      name: one.name,
      inputmode: "decimal",
      onchange: () => {
        const text = field.value.trim();
        /** @type {string[]} */ const entries = text ? text.split(/\s*[,;]\s*|\s+/) : [];
        const values = entries.map((entry) => (entry ? Number(entry) : NaN));
        const { min, max } = counts(this.app.state);
        const odd = values.findIndex((value) => !Number.isFinite(value));
        const wrong = entries[odd] ? `'${entries[odd]}' is not a number` : "is empty";
        const told = odd < 0 ? one.meaning : `${one.meaning}, entry ${odd + 1} ${wrong}`;
        if (odd >= 0 || values.length < min || values.length > max)
          return this.mark(one.name, `${told}: write ${min} to ${max} numbers with commas between them.`);
        set(values);
      },
    });
    shows.push((state) => write(field, [get(state)].flat().join(", ")));
    return element("div", { class: "row wide", title: one.meaning }, symbolOf(one), field);
  }

  /**
   * @param {string} label
   * @param {[string, string][]} options
   * @param {(value: string) => void} set
   * @param {(state: State) => string} get
   * @param {((state: State) => void)[]} [shows]
   */
  #select(label, options, set, get, shows = this.fixed) {
    const made = element(
      "select",
      { "aria-label": label, onchange: () => set(made.value) },
      ...options.map(([value, text]) => element("option", { value }, text)),
    );
    shows.push((state) => {
      const value = get(state);
      made.value = value;
      if (made.value !== value) made.selectedIndex = -1;
    });
    return made;
  }

  /**
   * Something that a model has or has not.
   * @param {string} label
   * @param {(model: Model) => boolean} get
   * @param {(model: Model, on: boolean) => Model} set
   * @param {(model: Model) => boolean} isFor
   */
  #switch(label, get, set, isFor) {
    const { app } = this;
    const box = element("input", {
      type: "checkbox",
      onchange: () => app.setModel(set(app.state.model, box.checked)),
    });
    const row = element("label", { class: "row check" }, box, label);
    this.fixed.push(({ model }) => {
      box.checked = get(model);
      row.hidden = !isFor(model);
    });
    return row;
  }

  /** @param {string} name @param {(Node | string)[]} children */
  #group(name, ...children) {
    return element("fieldset", {}, element("legend", {}, name), ...children);
  }

  // --- groups ----------------------------------------------------------------------------------

  #preset() {
    const { app, presets } = this;
    const choose = element(
      "select",
      {
        "aria-label": "Preset",
        onchange: () => {
          const preset = presets.find(({ name }) => name === choose.value);
          if (preset) app.store.update(completeState(app.limits, preset.state), "preset");
        },
      },
      element("option", { value: "" }, "Choose a system or figure …"),
      ...presets.map(({ name, title }) => element("option", { value: name }, title)),
    );
    this.fixed.push((state) => {
      const fits = presets.filter((one) => same(one.state.model, state.model));
      const whole = fits.find((one) => same(completeState(app.limits, one.state), state));
      if (whole || !fits.some(({ name }) => name === choose.value))
        choose.value = (whole ?? fits[0])?.name ?? "";
    });
    if (app.alone) return this.#group("Preset", choose);
    const file = element("input", { type: "file", accept: ".toml", hidden: true, "data-open": true });
    file.addEventListener("change", () => this.#open(file.files[0]).finally(() => (file.value = "")));
    const look = { type: "button", class: "tool", onclick: () => file.click() };
    return this.#group("Preset", choose, element("button", look, "Open a model file …"), file);
  }

  /** Show the plant of a model file. @param {File | undefined} file */
  async #open(file) {
    if (!file) return;
    const { state, error } = await fetch(new URL("open", location.href), { method: "POST", body: file })
      .then((reply) => reply.json())
      .catch(() => ({ error: "the server does not answer" }));
    if (error) return this.mark(null, `${file.name}: ${error}`);
    this.app.store.update(completeState(this.app.limits, state), "preset");
  }

  #model() {
    const { app } = this;
    const kinds = app.limits.models.map(
      ({ kind, title }) => /** @type {[string, string]} */ ([kind, title]),
    );
    const set = (/** @type {string} */ kind) =>
      app.setModel(defaultModel(app.limits, kind, lawOf(app.state.model)));
    return this.#group(
      "Model",
      this.#select("Model", kinds, set, ({ model }) => model.kind),
      this.#switch(
        "harmonic forces",
        ({ forcing }) => Boolean(forcing),
        (model, on) => withForcing(app.limits, model, on),
        ({ kind }) => kindEntry(app.limits, kind).forcing.length > 0,
      ),
      this.modelRows,
    );
  }

  #law() {
    return this.#group(
      "Friction",
      this.#switch("a law for each block", hasLaws, withLaws, hasBlocks),
      this.lawRows,
      this.lawHost,
    );
  }

  /** The choice of one block's law, or of all blocks'. @param {number} block @param {boolean} each */
  #lawOf(block, each) {
    const { app } = this;
    const laws = app.limits.laws.map(
      ({ law, title }) => /** @type {[string, string]} */ ([law, title]),
    );
    const put = (/** @type {any} */ law) => app.setModel(withLaw(app.state.model, block, law));
    const label = each ? `Friction law of ${whatRubs(app.state.model)} ${block + 1}` : "Friction law";
    const now = (/** @type {State} */ { model }) => lawsOf(model)[block];
    const choice = this.#select(
      label,
      [...laws, ["formula", "A formula of one's own"]],
      (law) => put(law === "formula" ? { ...FORMULA } : defaultLaw(app.limits, law)),
      (state) => (isFormula(app.limits, now(state)) ? "formula" : now(state).law),
      this.changing,
    );
    const row = each
      ? element("div", { class: "row wide" }, element("b", {}, `${block + 1}`), choice)
      : choice;
    if (!isFormula(app.limits, now(app.state))) return [row];
    const typed = element("input", {
      type: "text",
      "aria-label": `${label}: formula in the slip speed s`,
      name: each ? `law_${block + 1}` : "law",
      spellcheck: "false",
      onchange: () => put(withFormula(now(app.state), typed.value)),
    });
    this.changing.push((state) => write(typed, now(state).law));
    const symbol = element("span", { class: "symbol", "aria-hidden": "true" }, "F");
    return [row, element("div", { class: "row wide", title: "in the slip speed s" }, symbol, typed)];
  }

  #map() {
    const { app } = this;
    const rows = ["max_period", "power"].map((name) => {
      const known = app.limits.requests.event_map[name];
      const looks =
        name === "power"
          ? { symbol: "p", meaning: "power of the map shown" }
          : { symbol: "N", meaning: "orbits listed up to period" };
      const one = { name, ...looks, ...known, step: 1, whole: true };
      return this.#number(
        one,
        (state) => /** @type {any} */ (state)[name],
        (value) => app.store.update({ [name]: value }, name),
        this.fixed,
      );
    });
    const group = this.#group("Map", ...rows);
    this.fixed.push((state) => (group.hidden = !hasLineMap(state)));
    return group;
  }

  #along() {
    const { app, player } = this;
    this.along = element("select", {
      "aria-label": "Parameter of the diagram",
      onchange: () => {
        const { model, diagram } = app.state;
        const { max_period } = diagram;
        const given = { parameter: this.along.value, max_period };
        app.store.update({ diagram: completeAlong(app.limits, model, given) }, "along");
      },
    });
    const ends = [0, 1].map((end) =>
      element("input", {
        type: "number",
        step: "any",
        "aria-label": end ? "to" : "from",
        name: `range[${end}]`,
        onchange: () => this.#setEnd(end, ends[end].valueAsNumber),
      }),
    );
    this.fixed.push(({ diagram }) => {
      this.along.value = diagram.parameter;
      ends.forEach((input, end) => write(input, String(diagram.range[end])));
    });
    const play = playButton("Play along the parameter", () => player.toggle());
    player.onchange = (playing) => play.setAttribute("aria-pressed", String(playing));
    const group = this.#group(
      "Along a parameter",
      this.along,
      element(
        "div",
        { class: "row ends" },
        ends[0],
        element("span", { "aria-hidden": "true" }, "…"),
        ends[1],
      ),
      element(
        "div",
        { class: "row buttons" },
        iconButton("back", "Step back", () => player.step(-1)),
        play,
        iconButton("forward", "Step on", () => player.step(1)),
      ),
    );
    this.fixed.push((state) => {
      group.hidden = !hasLineMap(state);
      if (group.hidden) player.stop();
    });
    return group;
  }

  /** @param {number} end @param {number} value */
  #setEnd(end, value) {
    const { diagram } = this.app.state;
    const range = /** @type {[number, number]} */ ([...diagram.range]);
    range[end] = value;
    if (!(range[0] < range[1])) {
      const given = Number.isNaN(value) ? "no number" : value;
      const allowed = `${end ? "more" : "less"} than ${range[1 - end]}, the range's other end`;
      const of = `${this.app.written(diagram.parameter)}, ${end ? "to" : "from"}`;
      return this.mark(`range[${end}]`, `${of} = ${given}: it must be ${allowed}.`);
    }
    this.app.store.update({ diagram: { ...diagram, range, full: range, view: null } }, "range");
  }

  #motion() {
    const { app } = this;
    const { clock } = app;
    this.time = element("output", { class: "time", "aria-label": "time" }, "0.0");
    this.playButton = playButton("Play the motion", () => this.playMotion(!clock.playing));
    const speed = element("input", {
      type: "range",
      min: 0,
      max: 2,
      step: 0.05,
      value: Math.log10(clock.speed),
      "aria-label": "speed, slider",
      oninput: () => (clock.speed = 10 ** speed.valueAsNumber),
    });
    const numeric = { default: 0, min: -1, max: 1, step: 0.001 };
    const start = {
      ...numeric,
      name: "d",
      symbol: "d",
      meaning: "start: X₂ − X₁ while both stick",
    };
    this.fixed.push((state) => {
      const [min, max] = mapOf(state).domain ?? [numeric.min, numeric.max];
      Object.assign(start, { min, max, ...stepOf(min, max) });
    });
    const pointed = (/** @type {State} */ state) => {
      stick.querySelector(".symbol").textContent = app.written("d");
      const of = sticksAsOne(state.model) ? "X₂ − X₁ while both stick" : "a point of the return map";
      const left = startPoint(state) === state.d ? "" : `, the middle: ${state.d} lies outside by now`;
      stick.querySelector(".word").textContent = stick.title = spelled(`start: ${of}${left}`);
    };
    const stick = this.#number(
      start,
      startPoint,
      (d) => app.startAt(d),
      this.fixed,
    );
    const states = /** @type {const} */ ([
      ["x", "X", "displacements at the start of the motion, 0 if not given"],
      ["v", "X′", "velocities at the start of the motion, 0 if not given"],
    ]).map(([name, symbol, meaning]) => {
      const now = (/** @type {State} */ state) => startState(state.model, state)[name];
      const row = this.#list(
        { ...numeric, name, symbol, meaning },
        now,
        (values) => app.store.update({ [name]: values }, name),
        this.fixed,
        (state) => ({ min: 0, max: now(state).length }),
      );
      this.fixed.push((state) => (row.hidden = hasLineMap(state) || !now(state).length));
      return row;
    });
    this.fixed.push((state) => {
      stick.hidden = !hasLineMap(state);
      pointed(state);
    });
    const duration = {
      name: "t_end",
      symbol: "T",
      meaning: "duration of the motion",
      default: 120,
      min: 1,
      max: 500,
      step: 1,
    };
    return this.#group(
      "Motion",
      stick,
      ...states,
      element(
        "div",
        { class: "row buttons" },
        this.playButton,
        element("span", { class: "time-label" }, "t = ", this.time),
        speed,
      ),
      this.#number(
        duration,
        ({ t_end }) => t_end,
        (t_end) => app.store.update({ t_end }, "t_end"),
        this.fixed,
      ),
    );
  }

  /** @param {boolean} playing */
  playMotion(playing) {
    this.app.clock.play(playing);
    this.playButton?.setAttribute("aria-pressed", String(playing));
  }

  /**
   * Say what is wrong with what was typed, until something changes.
   * @param {string | null} field
   * @param {string} message
   */
  mark(field, message) {
    this.typed = { fields: field ? [field] : [], message };
    this.#mark();
  }

  /** What the server says of numbers, named as the page names them. @param {string} text */
  #symbolic(text) {
    const { limits, state } = this.app;
    const { ofModel, ofLaws } = this.#listed(state);
    const all = [limits.laws.flatMap(({ parameters }) => parameters), ofModel, ofLaws.flat()].flat();
    const symbols = new Map(all.map(({ name, symbol }) => [name, written(symbol)])).set("t_end", "T");
    const titles = new Map(limits.laws.map(({ law, title }) => [law, title]));
    return text
      .replace(NUMBER, (name, base, index) =>
        symbols.get(name) ?? (symbols.has(base) ? symbols.get(base) + index : name),
      )
      .replace(/(?<=friction law )[\w-]+/g, (law) => titles.get(law) ?? law);
  }

  #mark() {
    const { fields, message: text } = this.typed.message ? this.typed : this.told;
    const message = spelled(unquoted(text, (part) => this.#symbolic(part)));
    if (this.error.textContent === message) return;
    this.error.hidden = !message;
    this.error.textContent = message;
    const last = (/** @type {string} */ name) => name.split(".").at(-1) ?? "";
    const stem = (/** @type {string} */ name) => last(name).replace(/(_\d+)+$|\[\d+\]$/, "");
    const inputs = /** @type {HTMLInputElement[]} */ ([
      ...document.querySelectorAll(".controls input[name]"),
    ]);
    const named = (/** @type {(name: string) => string} */ of) =>
      inputs.filter(({ name }) => message && fields.some((field) => of(name) === of(field)));
    const [one, all] = [named(last), named(stem)]; // a list has one field for all its entries
    for (const input of inputs)
      if ((one.length ? one : all).includes(input)) input.setAttribute("aria-invalid", "true");
      else input.removeAttribute("aria-invalid");
  }
}

/** The name of a number, and its index, where a text says something of its value. */
const NUMBER = /(?<![\w.])([A-Za-z][\w.]*?)((?:_\d+)*)(?= (?:=|<=|must be|a value))|(?<=<= )([A-Za-z]\w*)/g;

/** Whether it is blocks that may have one law or several. @param {Model} model */
const hasBlocks = (model) => blockCount(model) > 1 && !isStructure(model);

/** A parameter's symbol, its index lowered. @param {Parameter} one */
function symbolOf({ symbol }) {
  const [letter, index] = symbol.split("_");
  const low = index ? [element("sub", {}, index)] : [];
  return element("span", { class: "symbol", "aria-hidden": "true" }, letter, ...low);
}

/** Steps of the arrow keys, a thousand or so to a slider. @param {number} min @param {number} max */
const stepOf = (min, max) => ({ step: 10 ** Math.floor(Math.log10(max - min) - 2.5) });

const NOTCHES = 1000;

/**
 * A slider over a range, even or logarithmic; the arrow keys go by the parameter's step, ten with Shift.
 * @param {Parameter} one @param {string} label @param {(value: number) => void} set
 */
function sliderOf(one, label, set) {
  const log = one.scale === "log" && one.min > 0;
  const share = (/** @type {number} */ value) =>
    log
      ? Math.log(value / one.min) / Math.log(one.max / one.min)
      : (value - one.min) / (one.max - one.min);
  const value = (/** @type {number} */ notch) =>
    log
      ? one.min * (one.max / one.min) ** (notch / NOTCHES)
      : one.min + ((one.max - one.min) * notch) / NOTCHES;
  const rounded = (/** @type {number} */ at) => clean(Math.round(at / one.step) * one.step);
  let now = one.default;
  const input = element("input", {
    type: "range",
    min: 0,
    max: NOTCHES,
    step: "any",
    "aria-label": `${label}, slider`,
    "data-slider": one.name,
    oninput: () => set(rounded(value(input.valueAsNumber))),
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      const steps = {
        ArrowLeft: -1,
        ArrowDown: -1,
        ArrowRight: 1,
        ArrowUp: 1,
        PageDown: -10,
        PageUp: 10,
      }[event.key];
      if (!steps) return;
      event.preventDefault();
      const to = now + steps * (event.shiftKey ? 10 : 1) * one.step;
      // A value that was typed beyond an end comes back from there step by step.
      set(clean(Math.min(Math.max(one.max, now), Math.max(Math.min(one.min, now), to))));
    },
  });
  return {
    input,
    /** @param {number} at */
    show: (at) => {
      now = at;
      input.value = String(NOTCHES * Math.min(1, Math.max(0, share(at))));
      input.setAttribute("aria-valuetext", spelled(String(at)));
    },
  };
}
