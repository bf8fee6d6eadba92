/**
 * Reading and changing models, which are plain tables.
 *
 * @import {MapTold, Model, Limits, Parameter} from "./types.js"
 */

/** Whether it is written as matrices and contacts. @param {Model} model */
export const isStructure = (model) => Array.isArray(model.contact);

/** Whether its numbers are read off the model itself. @param {Model} model */
export const hasMatrices = (model) => isStructure(model) || model.kind === "blocks";

/** Number of contacts; of blocks as many. @param {Model} model @returns {number} */
export function blockCount(model) {
  if (isStructure(model)) return model.contact.length;
  if (model.kind === "two_block") return 2;
  const perBlock = model.static ?? model.mass;
  return Array.isArray(perBlock) ? perBlock.length : 1;
}

/**
 * A state as long as the model's: displacements and velocities, 0 where none are given; in
 * state-space form all are displacements.
 * @param {Model} model @param {{x: number[], v: number[]}} given
 */
export function startState(model, { x, v }) {
  const count = (model.A ?? (isStructure(model) ? model.mass : { length: blockCount(model) })).length;
  const filled = (/** @type {number[]} */ values) =>
    Array.from({ length: count }, (_, k) => values[k] ?? 0);
  return { x: filled(x), v: model.A ? [] : filled(v) };
}

/**
 * Which map a model has: of the distances between blocks at global stick, which is known at once but
 * for its domain, else what the server said of a return map.
 * @param {{model: Model, map?: MapTold | null}} state @returns {MapTold}
 */
export function mapOf({ model, map }) {
  const count = blockCount(model);
  if (!sticksAsOne(model))
    return map ?? { kind: "unknown", why: "", coordinates: [], domain: null };
  const kind = count === 2 ? "line" : "space";
  return { kind, why: "", coordinates: Array(count - 1).fill("d"), domain: map?.domain ?? null };
}

/**
 * The point of a map of the line that the motion starts from: the middle of the domain, where that has
 * left behind the one that was set.
 * @param {{model: Model, d: number, map?: MapTold | null}} state
 */
export function startPoint(state) {
  const [low, high] = mapOf(state).domain ?? [-Infinity, Infinity];
  return state.d >= low && state.d <= high ? state.d : (low + high) / 2;
}

/**
 * What is shown of a map of the line, if that is not all: nothing of a window which the domain has left
 * behind.
 * @param {import("./types.js").State} state @param {string} panel
 */
export function windowOf(state, panel) {
  const box = state.windows[panel] ?? null;
  const [low, high] = mapOf(state).domain ?? [-Infinity, Infinity];
  return box && box[0] < high && box[1] > low ? box : null;
}

/** Whether the event map is from one global stick to the next. @param {Model} model */
export const sticksAsOne = (model) =>
  !isStructure(model) && !model.forcing && blockCount(model) > 1;

/** @param {{model: Model, map?: MapTold | null}} state */
export const hasLineMap = (state) => mapOf(state).kind === "line";

/** Whether it is a map of the plane, or of more numbers. @param {{model: Model, map?: MapTold | null}} state */
export const hasSpaceMap = (state) => mapOf(state).kind === "space";

/** Symbols of the numbers of a map's point. @param {{model: Model, map?: MapTold | null}} state */
export const coordinatesOf = (state) =>
  mapOf(state).coordinates.map((name) => (name === "phase" ? "φ" : name));

/** Of the one number of a map of the line; d between blocks. @param {{model: Model, map?: MapTold | null}} state */
export const coordinateOf = (state) => coordinatesOf(state)[0] ?? "d";

/** A symbol with its index as `mathText` reads it: V_dr is V_{dr}. @param {string} symbol */
export const indexed = (symbol) => symbol.replace(/_([\w,]+)/, "_{$1}");

/** Whether each block has a law of its own. @param {Model} model */
export const hasLaws = (model) => isStructure(model) || Array.isArray(model.friction);

/**
 * The laws' tables: one for all blocks, or one for each.
 * @param {Model} model
 * @returns {any[]}
 */
export const lawsOf = (model) =>
  isStructure(model)
    ? model.contact.map((/** @type {any} */ { friction }) => friction)
    : [model.friction].flat();

/** Of the first block. @param {Model} model @returns {string} */
export const lawOf = (model) => lawsOf(model)[0].law;

/**
 * What is known of a kind; of one that a notebook may show, nothing.
 * @param {Limits} limits
 * @param {string} kind
 */
export const kindEntry = (limits, kind) =>
  limits.models.find((entry) => entry.kind === kind) ?? {
    kind,
    title: kind,
    parameters: [],
    forcing: [],
    default: {},
    blocks: undefined,
  };

/** What is known of a law, as of a kind. @param {Limits} limits @param {string} law */
const lawEntry = (limits, law) =>
  limits.laws.find((entry) => entry.law === law) ?? {
    law,
    title: law,
    parameters: [],
    default: { law },
  };

/**
 * What is alike in systems that differ in their numbers alone: their answers have the same coordinates.
 * @param {{model: Model, section: any}} state
 */
export const shapeOf = ({ model, section }) =>
  JSON.stringify([model, section], (key, value) =>
    typeof value === "number" && key !== "at" ? undefined : value,
  );

/** What a formula of one's own begins as. */
export const FORMULA = { law: "mu + (1 - mu) * exp(-s / v)", mu: 0.3, v: 0.1 };

/** Whether a law is written as a formula. @param {Limits} limits @param {any} law */
export const isFormula = (limits, { law }) =>
  law !== "tabulated" && !limits.laws.some((entry) => entry.law === law);

/** Another formula, whose names keep their values. @param {any} law @param {string} text */
export function withFormula(law, text) {
  const names = text.match(/(?<![\w.])[A-Za-z_]\w*\b(?!\s*\()/g) ?? [];
  const own = names.filter((name) => name !== "s");
  return { law: text, ...Object.fromEntries(own.map((name) => [name, law[name] ?? 0.1])) };
}

/** Parameters of a law, those of a formula by their names. @param {Limits} limits @param {any} law */
function parametersOfLaw(limits, law) {
  if (!isFormula(limits, law)) return lawEntry(limits, law.law).parameters;
  return Object.keys(law)
    .filter((name) => typeof law[name] === "number")
    .map((name) => ({
      ...{ name, symbol: name, meaning: `${name} in the formula` },
      ...{ default: 0.1, min: 0, max: 2, step: 0.001 },
    }));
}

/** What rubs, in the words of a model. @param {Model} model */
export const whatRubs = (model) => (isStructure(model) ? "contact" : "block");

/** What the library says, which has both words for it. @param {Model} model @param {string} text */
export const inWordsOf = (model, text) => text.replace(/\b(?:block|contact)(?=s?\b)/g, whatRubs(model));

/**
 * Parameters of a model's kind, of what forces it and of its laws; names are those of the library,
 * `mu_2` where each block has a law.
 * @param {Limits} limits @param {Model} model @param {Kept} [kept]
 * @returns {{ofModel: Parameter[], ofLaws: Parameter[][]}}
 */
export function parametersOf(limits, model, kept = {}) {
  const { parameters, forcing } = kindEntry(limits, model.kind);
  const what = whatRubs(model);
  const ofLaws = lawsOf(model).map((law, k) =>
    parametersOfLaw(limits, law)
      .filter(({ name }) => name !== "viscous" || !model.contact?.[k].stiffness) // its foot takes no other
      .map((one) => (hasLaws(model) ? ofBlock(one, k + 1, what) : one)),
  );
  if (hasMatrices(model)) return { ofModel: entriesOf(model, kept).map(({ one }) => one), ofLaws };
  if (!model.forcing) return { ofModel: parameters, ofLaws };
  // What is forced may rub on ground at rest: a slider from 0 is even.
  const own = parameters.map((one) => (one.name === "V" ? { ...one, min: 0 } : one));
  return { ofModel: [...own, ...forcing], ofLaws };
}

/** @param {Parameter} one @param {number} block  from 1 @param {string} what @returns {Parameter} */
function ofBlock(one, block, what) {
  const [letter, index] = one.symbol.split("_");
  return {
    ...one,
    name: `${one.name}_${block}`,
    symbol: `${letter}_${index ? `${index},` : ""}${block}`,
    meaning: `${what} ${block}: ${one.meaning}`,
  };
}

/** Those along which a diagram can go. @param {Limits} limits @param {Model} model @param {Kept} [kept] */
export function continuousParameters(limits, model, kept) {
  const { ofModel, ofLaws } = parametersOf(limits, model, kept);
  return [...ofModel, ...ofLaws.flat()].filter((one) => !one.per_block && !one.values);
}

/** What a structure's numbers stand in, beside its contacts and forces: lists, or lists of rows. */
const LISTS = ["mass", "stiffness", "damping", "force", "A", "B", "C", "a"];

/**
 * What keeps the page from showing a model that an address gives whole, in words; empty if nothing does.
 * Whether its numbers make sense the server says.
 * @param {any} model
 */
export function faultOf(model) {
  const isTable = (/** @type {any} */ one) => one instanceof Object && !Array.isArray(one);
  if (!isTable(model) || typeof model.kind !== "string") return "its model has no kind";
  const contacts = isStructure(model) ? model.contact : [];
  const bare = contacts.findIndex((/** @type {any} */ one) => !isTable(one));
  if (bare >= 0) return `contact ${bare + 1} of its model is no table`;
  const lawless = lawsOf(model).findIndex((law) => typeof law?.law !== "string");
  if (lawless >= 0) return `friction law ${lawless + 1} of its model has no name`;
  const waves = [model, ...contacts].flatMap(({ forcing, belt }) => forcing ?? belt ?? []);
  if (!waves.every(isTable)) return "a force or a belt of its model is no table";
  if (!isStructure(model)) return "";
  if (!model.A && !model.mass) return "its model has no mass";
  const parts = [model, ...contacts.map((/** @type {any} */ { load }) => ({ load }))];
  const scalar = [...LISTS, "load"].find((key) => !parts.every((one) => Array.isArray(one[key] ?? [])));
  return scalar ? `${scalar} of its model is no list` : "";
}

/** @typedef {Record<string, any>} Kept  names of numbers that are listed though they are 0, which others are not */

/** @typedef {(string | number)[]} Path  keys, the last of them a value's own */

const SYMBOLS = {
  mass: ["m", "mass"],
  stiffness: ["k", "stiffness"],
  damping: ["c", "damping"],
  force: ["f", "constant force"],
  A: ["A", "entry of A"],
  B: ["B", "entry of B"],
  C: ["C", "entry of C"],
  a: ["a", "constant part"],
  static: ["L", "static limit of contact"],
  V: ["V", "velocity of the belt of contact"],
  limit: ["L", "static limit of block"],
  belt: ["V_dr", "driving velocity"],
  load: ["l", "limit per displacement"],
  contact_stiffness: ["k", "spring in series with contact"],
  amplitude: ["a", "amplitude of the force"],
  frequency: ["Ω", "angular frequency"],
  phase: ["φ", "phase at time 0"],
};

const EVERYWHERE = new Set(["static", "V", "amplitude", "frequency", "phase"]); // 0 is a value there

/** What a model wants positive, or not 0. */
const POSITIVE = ["mass", "static", "limit", "belt", "contact_stiffness", "frequency", "B", "C"];

/** What a contact has where its table does not say. @type {Record<string, number>} */
const UNSAID = { static: 1, V: 0 };

/**
 * Numbers of matrices and contacts: named as the library names them, each with the places where it is.
 * @param {Model} model @param {Kept} kept
 */
function entriesOf(model, kept) {
  /** @type {{one: Parameter, paths: Path[]}[]} */ const entries = [];
  const add = (/** @type {string} */ name, /** @type {string} */ stem, /** @type {Path[]} */ paths) => {
    const value = at(model, paths[0]) ?? UNSAID[stem];
    if (value === 0 && !EVERYWHERE.has(stem) && !(name in kept)) return;
    const [letter, meaning] = /** @type {any} */ (SYMBOLS)[stem] ?? [stem, stem];
    const index = name.match(/\d+/g)?.join() ?? "";
    const told = { symbol: index ? `${letter}_${index}` : letter, meaning: `${meaning} ${index}`.trim() };
    const isPositive = POSITIVE.includes(stem) || (stem === "stiffness" && !isStructure(model)); // definite
    entries.push({ one: { name, ...told, default: value, ...rangeAbout(value, isPositive) }, paths });
  };
  (model.static ?? []).forEach((/** @type {number} */ _, /** @type {number} */ k) =>
    add(`static_${k + 1}`, "limit", [["static", k]]),
  );
  if (model.V !== undefined) add("V", "belt", [["V"]]);
  (model.contact ?? []).forEach((/** @type {any} */ contact, /** @type {number} */ k) => {
    const inside = (/** @type {Path} */ ...keys) => [/** @type {Path} */ (["contact", k, ...keys])];
    add(`static_${k + 1}`, "static", inside("static"));
    add(`V_${k + 1}`, "V", inside("V"));
    (contact.load ?? []).forEach((/** @type {number} */ _, /** @type {number} */ j) =>
      add(`load_${k + 1}_${j + 1}`, "load", inside("load", j)),
    );
    if (contact.stiffness !== undefined)
      add(`contact_stiffness_${k + 1}`, "contact_stiffness", inside("stiffness"));
    for (const key of Object.keys(contact.belt ?? {}))
      add(`V_${k + 1}.${key}`, key, inside("belt", key));
  });
  const waves = [model.forcing ?? []].flat();
  waves.forEach((wave, k) => {
    const place = Array.isArray(model.forcing) ? ["forcing", k] : ["forcing"];
    const prefix = waves.length > 1 ? `forcing_${k + 1}` : "forcing";
    for (const [key, value] of Object.entries(wave)) {
      if (Array.isArray(value))
        value.forEach((part, j) => {
          const name = `${prefix}.${key}_${j + 1}`;
          if (part || name in kept) add(name, key, [[...place, key, j]]);
        });
      else add(`${prefix}.${key}`, key, [[...place, key]]);
    }
  });
  for (const stem of LISTS) {
    const rows = model[stem] ?? [];
    const pairs = ["mass", "stiffness", "damping"].includes(stem) && isSymmetric(rows);
    rows.forEach((/** @type {any} */ row, /** @type {number} */ i) => {
      if (!Array.isArray(row)) return add(`${stem}_${i + 1}`, stem, [[stem, i]]);
      row.forEach((_, j) => {
        if (pairs && j < i) return;
        const mirror = pairs && j > i ? [/** @type {Path} */ ([stem, j, i])] : [];
        add(`${stem}_${i + 1}_${j + 1}`, stem, [[stem, i, j], ...mirror]);
      });
    });
  }
  return entries;
}

/** @param {any} rows */
const isSymmetric = (rows) =>
  rows.every(
    (/** @type {any} */ row, /** @type {number} */ i) =>
      !Array.isArray(row) || row.every((value, j) => value === rows[j]?.[i]),
  );

/** What a slider spans about a value: from 0 to twice it, or half as far. @param {number} value @param {boolean} isPositive */
function rangeAbout(value, isPositive) {
  const reach = Math.abs(value) / (isPositive ? 2 : 1) || 1;
  const min = isPositive && value === 0 ? 0 : value - reach;
  return { min, max: value + reach, step: 10 ** Math.floor(Math.log10(2 * reach) - 3) };
}

/** Of how many numbers of a model each has a slider; of more those of contacts and forces. */
const FEW = 12;

/**
 * Ranges of the sliders that matrices begin with: those of a preset, else about its values.
 * @param {Limits} limits @param {Model} model @returns {Record<string, [number, number]>}
 */
export function slidersOf(limits, model) {
  if (!hasMatrices(model)) return {};
  const { ofModel, ofLaws } = parametersOf(limits, model);
  const ofLaw = ofLaws.flat().filter((one) => !one.values);
  const all = [...ofModel, ...ofLaw];
  const first = (/** @type {Parameter} */ { name }) => /^(static|V|load|contact|forcing)/.test(name);
  const some = all.length <= FEW ? all : [...ofModel.filter(first), ...ofLaw].slice(0, FEW);
  return Object.fromEntries(some.map(({ name, min, max }) => [name, [min, max]]));
}

/** @param {any} table @param {Path} keys @returns {any} */
const at = (table, keys) => keys.reduce((found, key) => found?.[key], table);

/**
 * Where in a model a parameter's value is; both entries of a symmetric matrix.
 * @param {Limits} limits @param {Model} model @param {string} name @returns {Path[]}
 */
function pathsTo(limits, model, name) {
  const { ofLaws } = parametersOf(limits, model);
  const block = ofLaws.findIndex((list) => list.some((one) => one.name === name));
  if (block >= 0 && !hasLaws(model)) return [["friction", name]];
  const own = name.replace(/_\d+$/, "");
  if (block >= 0 && !isStructure(model)) return [["friction", block, own]];
  if (block >= 0) return [["contact", block, "friction", own]];
  const entry = hasMatrices(model) && entriesOf(model, { [name]: true }).find(({ one }) => one.name === name);
  return entry ? entry.paths : [name.split(".")];
}

/** @param {Limits} limits @param {Model} model @param {string} name @returns {any} */
export function valueOf(limits, model, name) {
  const { ofModel, ofLaws } = parametersOf(limits, model);
  const entry = [...ofModel, ...ofLaws.flat()].find((one) => one.name === name);
  return at(model, pathsTo(limits, model, name)[0]) ?? entry?.default;
}

/**
 * A changed copy.
 * @param {Limits} limits @param {Model} model @param {string} name @param {any} value
 * @returns {Model}
 */
export function withValue(limits, model, name, value) {
  const copy = structuredClone(model);
  for (const keys of pathsTo(limits, model, name)) {
    /** @type {any} */ let inside = copy;
    for (const key of keys.slice(0, -1)) inside = inside[key] ??= {};
    inside[/** @type {string} */ (keys.at(-1))] = value;
  }
  return Array.isArray(copy.friction) ? withLaws(copy, true) : copy;
}

/**
 * With another law of one block or contact; of all, where they have one.
 * @param {Model} model @param {number} block @param {any} law @returns {Model}
 */
export function withLaw(model, block, law) {
  if (!hasLaws(model)) return { ...model, friction: law };
  if (!isStructure(model)) return { ...model, friction: model.friction.with(block, law) };
  return { ...model, contact: model.contact.with(block, { ...model.contact[block], friction: law }) };
}

/**
 * With a law for each block, those without one like the last that has; or with one for all.
 * @param {Model} model @param {boolean} each @returns {Model}
 */
export function withLaws(model, each) {
  const laws = lawsOf(model);
  if (!each) return { ...model, friction: laws[0] };
  const friction = Array.from({ length: blockCount(model) }, (_, k) =>
    structuredClone(laws[Math.min(k, laws.length - 1)]),
  );
  return { ...model, friction };
}

/**
 * With harmonic forces on the blocks, or without.
 * @param {Limits} limits @param {Model} model @param {boolean} forced @returns {Model}
 */
export function withForcing(limits, model, forced) {
  const { forcing: _, ...rest } = model;
  if (!forced) return rest;
  const values = kindEntry(limits, model.kind).forcing.map((one) => [
    one.name.replace("forcing.", ""),
    one.default,
  ]);
  return { ...rest, forcing: Object.fromEntries(values) };
}

/** @param {Limits} limits @param {string} law */
export const defaultLaw = (limits, law) => structuredClone(lawEntry(limits, law).default);

/**
 * A kind's default with a law, if the law is known.
 * @param {Limits} limits
 * @param {string} kind
 * @param {string} law
 * @returns {Model}
 */
export function defaultModel(limits, kind, law) {
  const model = structuredClone(kindEntry(limits, kind).default);
  const known = limits.laws.some((entry) => entry.law === law);
  if (known && !isStructure(model) && law !== lawOf(model)) {
    model.friction = defaultLaw(limits, law);
  }
  return model;
}
