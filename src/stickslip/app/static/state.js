/**
 * The state of the page: one object, changed in one place, remembered, written as an address.
 *
 * @import {State, Model, Limits, Along, Box} from "./types.js"
 */
import {
  continuousParameters,
  defaultModel,
  faultOf,
  hasLaws,
  hasLineMap,
  hasMatrices,
  lawsOf,
  parametersOf,
  slidersOf,
  valueOf,
  withForcing,
  withValue,
} from "./model.js";

const MERGE_MS = 900; // changes of one control that follow this closely are one step to undo
const MEMORY = 200;

export class Store {
  /** @param {State} state */
  constructor(state) {
    this.state = state;
    /** @type {State[]} */ this.past = [];
    /** @type {State[]} */ this.future = [];
    /** @type {Set<(state: State, learned: boolean) => void>} */ this.listeners = new Set();
    this.lastTag = "";
    this.lastTime = -Infinity;
  }

  /** @param {(state: State, learned: boolean) => void} listener */
  subscribe(listener) {
    this.listeners.add(listener);
  }

  /**
   * Change something; what changes nothing is no step to undo.
   * @param {Partial<State>} changes
   * @param {string} tag  changes with one tag, close in time, are undone together
   */
  update(changes, tag) {
    const next = { ...this.state, ...changes };
    if (same(next, this.state)) return this.#become(this.state); // what was typed wrong is taken back
    const now = performance.now();
    if (tag !== this.lastTag || now - this.lastTime > MERGE_MS) {
      this.past = [...this.past.slice(1 - MEMORY), this.state];
    }
    this.lastTag = tag;
    this.lastTime = now;
    this.future = [];
    this.#become(next);
  }

  undo() {
    this.#step(this.past, this.future);
  }

  redo() {
    this.#step(this.future, this.past);
  }

  /** @param {State[]} from @param {State[]} to */
  #step(from, to) {
    const state = from.pop();
    if (!state) return;
    to.push(this.state);
    this.lastTag = "";
    this.#become(state);
  }

  /** Complete the present state by what follows from it, which is no step to undo. @param {Partial<State>} told */
  learn(told) {
    this.#become({ ...this.state, ...told }, true);
  }

  /** Take a state from elsewhere without remembering the present one. @param {State} state */
  replace(state) {
    this.lastTag = "";
    this.#become(state);
  }

  /** @param {State} state @param {boolean} [learned]  whether nothing was changed by anybody */
  #become(state, learned = false) {
    this.state = state;
    for (const listener of this.listeners) listener(state, learned);
  }
}

/**
 * A whole state from the part of one that a preset or an address gives.
 * @param {Limits} limits
 * @param {Partial<State> & {window?: [number, number] | null}} given
 * @returns {State}
 */
export function completeState(limits, given) {
  const model = given.model ?? defaultModel(limits, limits.models[0].kind, "");
  return {
    model,
    d: typeof given.d === "number" ? given.d : 0.1,
    x: given.x ?? [0.1],
    v: given.v ?? [],
    t_end: given.t_end ?? 120,
    power: given.power ?? 2,
    max_period: given.max_period ?? 4,
    section: given.section ?? null,
    map: given.map ?? null,
    sliders: given.sliders ?? slidersOf(limits, model),
    diagram: completeAlong(limits, model, given.diagram),
    large: given.large ?? [],
    windows:
      given.windows ??
      (given.window ? { map: square(given.window), power: square(given.window) } : {}),
  };
}

/** A window of the map, on both axes. @param {[number, number]} window @returns {Box} */
const square = ([low, high]) => [low, high, low, high];

/**
 * @param {Limits} limits @param {Model} model @param {Partial<Along>} [given]
 * @returns {Along}
 */
export function completeAlong(limits, model, given = {}) {
  const known = continuousParameters(limits, model, { [given.parameter ?? ""]: true });
  const entry = known.find((one) => one.name === given.parameter) ??
    known.find((one) => one.name === "V") ??
    known[0] ?? { name: "V", min: 0, step: 0.001 };
  const fits = given.range && entry.name === given.parameter;
  const range = fits ? /** @type {[number, number]} */ (given.range) : around(limits, model, entry);
  const full = (fits && given.full) || range;
  const window = (fits && given.window) || null;
  const view = (fits && given.view) || null;
  return { parameter: entry.name, range, window, view, full, max_period: given.max_period ?? 4 };
}

/** A range about the present value, inside what the slider spans. */
function around(
  /** @type {Limits} */ limits,
  /** @type {Model} */ model,
  /** @type {any} */ entry,
) {
  const value = valueOf(limits, model, entry.name);
  if (typeof value !== "number") throw new Error(`${entry.name} of its model is no number`);
  const reach = Math.max(0.02 * Math.abs(value), 4 * entry.step);
  const low = Math.max(value - reach, Math.min(value, entry.min));
  return /** @type {[number, number]} */ ([clean(low), clean(value + reach)]);
}

/** A number without the dust of its last digits. @param {number} value */
export const clean = (value) => Number(value.toPrecision(12));

// --- the address -----------------------------------------------------------------------------

const escape = (/** @type {any} */ value) =>
  encodeURIComponent(String(value)).replaceAll("%3A", ":").replaceAll("%2C", ",");

/**
 * State as `kind=two_block&alpha=1.2&...`: the model, its law, then what is looked at.
 * @param {Limits} limits @param {State} state
 */
export function toFragment(limits, state) {
  const { parameter, range, window, view, full, max_period } = state.diagram;
  /** @type {[string, any][]} */
  const pairs = [
    ...modelPairs(limits, state.model),
    ...starts(state),
    ["t_end", state.t_end],
    ["power", state.power],
    ["max_period", state.max_period],
    ["along", [parameter, ...range].join(":")],
  ];
  pairs.push(["followed", max_period]);
  if (state.section) pairs.push(["section", JSON.stringify(state.section)]);
  if (hasMatrices(state.model)) pairs.push(["sliders", JSON.stringify(state.sliders)]);
  if (window) pairs.push(["window", window.join(":")]);
  if (view) pairs.push(["diagram", view.join(":")]);
  if (full.join() !== range.join()) pairs.push(["full", full.join(":")]);
  if (state.large.length) pairs.push(["large", state.large.join(",")]);
  for (const [panel, box] of Object.entries(state.windows)) {
    if (box) pairs.push([`zoom.${panel}`, box.join(":")]);
  }
  return pairs.map(([key, value]) => `${key}=${escape(value)}`).join("&");
}

/** @param {State} state @returns {[string, any][]} */
const starts = (state) =>
  hasLineMap(state)
    ? [["d", state.d]]
    : [
        ["x", state.x],
        ["v", state.v],
      ];

/**
 * A model by its parameters; one that has more than the controls show, as a table.
 * @param {Limits} limits
 * @param {Model} model
 * @returns {[string, any][]}
 */
function modelPairs(limits, model) {
  if (hasMatrices(model)) return [["model", JSON.stringify(model)]];
  const { friction: _, ...rest } = model;
  const laws = lawsOf(model).flatMap((law, k) =>
    Object.entries(law).map(([key, value]) => [hasLaws(model) ? `${key}_${k + 1}` : key, value]),
  );
  const pairs = [...flat(rest), .../** @type {[string, any][]} */ (laws)];
  const read = modelOf(limits, new Map(pairs.map(([key, value]) => [key, String(value)])));
  return same(read, model) ? pairs : [["model", JSON.stringify(model)]];
}

/**
 * Whether two tables hold the same, in any order.
 * @param {any} a
 * @param {any} b
 * @returns {boolean}
 */
export function same(a, b) {
  if (a === null || b === null || typeof a !== "object" || typeof b !== "object") return a === b;
  const keys = Object.keys(a);
  return keys.length === Object.keys(b).length && keys.every((key) => same(a[key], b[key]));
}

/** @param {Record<string, any>} table @param {string} [before] @returns {[string, any][]} */
const flat = (table, before = "") =>
  Object.entries(table).flatMap(([key, value]) =>
    value !== null && typeof value === "object" && !Array.isArray(value)
      ? flat(value, `${before}${key}.`)
      : [[before + key, value]],
  );

const WORDS = /^(kind|law(_\d+)?|model|section|sliders|along|large)$/;

/**
 * The state that an address names; what it leaves out takes its default.
 * @param {Limits} limits @param {Map<string, string>} given
 * @returns {State}
 * @throws where something in it cannot be read
 */
export function fromAddress(limits, given) {
  for (const [key, text] of given)
    if (!WORDS.test(key) && !text.split(/[,:]/).every((one) => Number.isFinite(Number(one))))
      throw new Error(`${key} = ${text} is no number`);
  const whole = given.has("model");
  const model = whole ? parsed(given.get("model")) : modelOf(limits, given);
  const wrong = whole ? faultOf(model) : model ? "" : "it names no known model and law";
  if (wrong) throw new Error(wrong);
  return completeState(limits, {
    model,
    d: number(given.get("d")),
    x: list(given.get("x")),
    v: list(given.get("v")),
    t_end: number(given.get("t_end")),
    power: number(given.get("power")),
    max_period: number(given.get("max_period")),
    section: sectionOf(given),
    sliders: pairs(parsed(given.get("sliders"))),
    diagram: along(given),
    windows: zooms(given),
    large: (given.get("large") ?? "").split(",").filter(Boolean),
  });
}

/**
 * The model that an address gives by its parameters.
 * @param {Limits} limits
 * @param {Map<string, string>} given
 */
function modelOf(limits, given) {
  const kind = given.get("kind") ?? "";
  const known = limits.laws.map(({ law }) => law);
  const named = [...given].filter(([key]) => /^law(_\d+)?$/.test(key)).map(([, law]) => law);
  if (!limits.models.some((entry) => entry.kind === kind)) return null;
  if (!named.every((law) => known.includes(law))) return null;
  let model = defaultModel(limits, kind, given.get("law") ?? "");
  if (given.has("forcing.amplitude")) model = withForcing(limits, model, true);
  const laws = [];
  for (let law; (law = given.get(`law_${laws.length + 1}`)); ) laws.push({ law });
  if (laws.length) model.friction = laws;
  const { ofModel, ofLaws } = parametersOf(limits, model);
  for (const { name } of [...ofModel, ...ofLaws.flat()]) {
    const text = given.get(name);
    if (text !== undefined)
      model = withValue(limits, model, name, parse(text, valueOf(limits, model, name)));
  }
  return model;
}

/** Settings of the return map. @param {Map<string, string>} given */
export function sectionOf(given) {
  const text = given.get("section");
  const table = parsed(text);
  if (text && !table) throw new Error(`section = ${text} is no table such as {"domain": [[low, high], ...]}`);
  return table;
}

/** @param {string | undefined} text @returns {any}  null of what is no table */
function parsed(text) {
  try {
    const table = JSON.parse(text ?? "");
    return typeof table === "object" ? table : null;
  } catch {
    return null;
  }
}

/** A table of pairs of numbers, if it is one. @param {any} table */
const pairs = (table) =>
  table && Object.values(table).every((ends) => ends?.length === 2 && ends.every(Number.isFinite))
    ? table
    : undefined;

/** @param {string} text @param {any} like */
function parse(text, like) {
  if (Array.isArray(like)) return text.split(",").map(Number);
  return number(text) ?? like;
}

/** @param {string | undefined} text */
function number(text) {
  const value = Number(text);
  return text !== undefined && text !== "" && Number.isFinite(value) ? value : undefined;
}

/** @param {string | undefined} text */
function list(text) {
  const values = (text ?? "").split(",").filter(Boolean).map(Number);
  return text !== undefined && values.every(Number.isFinite) ? values : undefined;
}

/** @param {string | undefined} text @param {number} count @returns {any} */
function numbers(text, count) {
  const values = (text ?? "").split(":").map(Number);
  return values.length === count && values.every(Number.isFinite) ? values : null;
}

/** @param {Map<string, string>} given @returns {any} */
function along(given) {
  const [parameter, ...rest] = (given.get("along") ?? "").split(":");
  return {
    parameter,
    range: numbers(rest.join(":"), 2) ?? undefined,
    window: numbers(given.get("window"), 2),
    view: numbers(given.get("diagram"), 2),
    full: numbers(given.get("full"), 2) ?? undefined,
    max_period: number(given.get("followed")),
  };
}

/** @param {Map<string, string>} given */
function zooms(given) {
  /** @type {Record<string, Box | null>} */
  const windows = {};
  for (const [key, text] of given) {
    if (key.startsWith("zoom.")) windows[key.slice(5)] = numbers(text, 4);
  }
  return windows;
}
