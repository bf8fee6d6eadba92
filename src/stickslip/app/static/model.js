/**
 * Reading and changing models, which are plain tables.
 *
 * @import {Model, Limits, Parameter} from "./types.js"
 */

/** @param {Model} model */
export function blockCount(model) {
  if (model.kind === "two_block") return 2;
  return Array.isArray(model.static) ? model.static.length : 1;
}

/** A number for each block, 0 where none is given. @param {Model} model @param {number[]} values */
export const perBlock = (model, values) =>
  Array.from({ length: blockCount(model) }, (_, k) => values[k] ?? 0);

/** Whether its event map is a map of an interval. @param {Model} model */
export const hasLineMap = (model) => blockCount(model) === 2 && !model.forcing;

/** Whether it is a map of the plane, or of more than two differences. @param {Model} model */
export const hasBlocksMap = (model) => blockCount(model) > 2 && !model.forcing;

/** A symbol with its index as `mathText` reads it: V_dr is V_{dr}. @param {string} symbol */
export const indexed = (symbol) => symbol.replace(/_(\w+)/, "_{$1}");

/** Whether each block has a law of its own. @param {Model} model */
export const hasLaws = (model) => Array.isArray(model.friction);

/**
 * The laws' tables: one for all blocks, or one for each.
 * @param {Model} model
 * @returns {any[]}
 */
export const lawsOf = (model) => [model.friction].flat();

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
    views: [],
    parameters: [],
    forcing: [],
    default: {},
    blocks: undefined,
  };

/** What is known of a law, as of a kind. @param {Limits} limits @param {string} law */
export const lawEntry = (limits, law) =>
  limits.laws.find((entry) => entry.law === law) ?? {
    law,
    title: law,
    parameters: [],
    default: { law },
  };

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

/**
 * Parameters of a model's kind, of what forces it and of its laws; names are those of the library,
 * `mu_2` where each block has a law.
 * @param {Limits} limits @param {Model} model
 * @returns {{ofModel: Parameter[], ofLaws: Parameter[][]}}
 */
export function parametersOf(limits, model) {
  const { parameters, forcing } = kindEntry(limits, model.kind);
  const ofLaws = lawsOf(model).map((law, k) =>
    parametersOfLaw(limits, law).map((one) => (hasLaws(model) ? ofBlock(one, k + 1) : one)),
  );
  return { ofModel: model.forcing ? [...parameters, ...forcing] : parameters, ofLaws };
}

/** @param {Parameter} one @param {number} block  from 1 @returns {Parameter} */
function ofBlock(one, block) {
  const [letter, index] = one.symbol.split("_");
  return {
    ...one,
    name: `${one.name}_${block}`,
    symbol: `${letter}_${index ? `${index},` : ""}${block}`,
    meaning: `block ${block}: ${one.meaning}`,
  };
}

/** Those along which a diagram can go. @param {Limits} limits @param {Model} model */
export function continuousParameters(limits, model) {
  const { ofModel, ofLaws } = parametersOf(limits, model);
  return [...ofModel, ...ofLaws.flat()].filter((one) => !one.per_block && !one.values);
}

/**
 * Where in a model a parameter's value is: keys, the last of them its own.
 * @param {Limits} limits @param {Model} model @param {string} name @returns {(string | number)[]}
 */
function pathTo(limits, model, name) {
  const { ofLaws } = parametersOf(limits, model);
  const block = ofLaws.findIndex((list) => list.some((one) => one.name === name));
  if (block < 0) return name.split(".");
  return hasLaws(model)
    ? ["friction", block, name.replace(/_\d+$/, "")]
    : ["friction", name];
}

/** @param {Limits} limits @param {Model} model @param {string} name @returns {any} */
export function valueOf(limits, model, name) {
  const { ofModel, ofLaws } = parametersOf(limits, model);
  const entry = [...ofModel, ...ofLaws.flat()].find((one) => one.name === name);
  /** @type {any} */ let at = model;
  for (const key of pathTo(limits, model, name)) at = at?.[key];
  return at ?? entry?.default;
}

/**
 * A changed copy.
 * @param {Limits} limits @param {Model} model @param {string} name @param {any} value
 * @returns {Model}
 */
export function withValue(limits, model, name, value) {
  const copy = structuredClone(model);
  const keys = pathTo(limits, model, name);
  const last = /** @type {string} */ (keys.pop());
  /** @type {any} */ let at = copy;
  for (const key of keys) at = at[key] ??= {};
  at[last] = value;
  return hasLaws(copy) ? withLaws(copy, true) : copy;
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
  if (limits.laws.some((entry) => entry.law === law) && law !== lawOf(model)) {
    model.friction = defaultLaw(limits, law);
  }
  return model;
}
