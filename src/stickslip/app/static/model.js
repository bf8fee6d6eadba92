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

/** Whether its event map is a map of an interval. @param {Model} model */
export const hasLineMap = (model) => model.kind === "two_block";

/** A symbol with its index as `mathText` reads it: V_dr is V_{dr}. @param {string} symbol */
export const indexed = (symbol) => symbol.replace(/_(\w+)/, "_{$1}");

/**
 * The law's table: one for all blocks, or that of the first.
 * @param {Model} model
 * @returns {any}
 */
export const frictionOf = (model) => [model.friction].flat()[0];

/** @param {Model} model @returns {string} */
export const lawOf = (model) => frictionOf(model).law;

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

/**
 * Parameters of a model's kind and of its law.
 * @param {Limits} limits @param {Model} model
 * @returns {{ofModel: Parameter[], ofLaw: Parameter[]}}
 */
export const parametersOf = (limits, model) => ({
  ofModel: kindEntry(limits, model.kind).parameters,
  ofLaw: lawEntry(limits, lawOf(model)).parameters,
});

/** Those along which a diagram can go. @param {Limits} limits @param {Model} model */
export function continuousParameters(limits, model) {
  const { ofModel, ofLaw } = parametersOf(limits, model);
  return [...ofModel, ...ofLaw].filter((one) => !one.per_block && !one.values);
}

/** @param {Limits} limits @param {Model} model @param {string} name */
const entryOfLaw = (limits, model, name) =>
  lawEntry(limits, lawOf(model)).parameters.find((one) => one.name === name);

/** @param {Limits} limits @param {Model} model @param {string} name @returns {any} */
export function valueOf(limits, model, name) {
  const ofLaw = entryOfLaw(limits, model, name);
  const entry = ofLaw ?? kindEntry(limits, model.kind).parameters.find((one) => one.name === name);
  const table = ofLaw ? frictionOf(model) : model;
  return name.split(".").reduce((at, key) => at?.[key], table) ?? entry?.default;
}

/**
 * A changed copy.
 * @param {Limits} limits @param {Model} model @param {string} name @param {any} value
 * @returns {Model}
 */
export function withValue(limits, model, name, value) {
  const copy = structuredClone(model);
  if (entryOfLaw(limits, model, name)) {
    for (const law of [copy.friction].flat()) law[name] = value;
    return copy;
  }
  const keys = name.split(".");
  const last = /** @type {string} */ (keys.pop());
  let at = copy;
  for (const key of keys) at = at[key] ??= {};
  at[last] = value;
  return copy;
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
