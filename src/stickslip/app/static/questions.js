/**
 * What the page asks of the server, as functions of the state alone: equal questions are not asked again.
 *
 * @import {State, Question, Limits} from "./types.js"
 */
import { hasBlocksMap, hasLineMap, perBlock, withValue } from "./model.js";

const COBWEB_STEPS = 160;
const MOTION_SAMPLES = 6000;

/**
 * @typedef {Record<string, number>} Widths  of the panels' plots, in pixels
 * @typedef {(state: State, widths: Widths, limits: Limits) => Question} Ask
 */

/** Twice the pixels, in steps, so that a small change of the window asks nothing new. */
const resolution = (/** @type {number | undefined} */ width, /** @type {number} */ most) =>
  Math.min(most, 100 * Math.ceil((2 * (width || 400)) / 100));

/** @param {Limits} limits @param {string} view @param {string} field */
const most = (limits, view, field) => limits.requests[view][field].max;

const horizontal = (/** @type {any} */ box) => (box ? [box[0], box[1]] : null);

/** @type {Record<string, Ask>} */
export const QUESTIONS = {
  map: ({ model, windows, max_period }, widths, limits) => ({
    view: "event_map",
    request: {
      model,
      window: horizontal(windows.map),
      points: resolution(widths.map, most(limits, "event_map", "points")),
      power: 1,
      max_period,
    },
  }),
  power: ({ model, windows, power }, widths, limits) => ({
    view: "event_map",
    request: {
      model,
      window: horizontal(windows.power),
      points: resolution(widths.power, most(limits, "event_map", "points")),
      power,
      max_period: 0,
    },
  }),
  cobweb: ({ model, d }) => ({ view: "cobweb", request: { model, d, n: COBWEB_STEPS } }),
  basins: ({ model }) => ({ view: "basins", request: { model } }),
  motion: (state) => ({
    view: "motion",
    request: { model: state.model, ...startOf(state), t_end: state.t_end, samples: MOTION_SAMPLES },
  }),
  locus: ({ model }) => ({ view: "locus", request: { model } }),
  law: ({ model }) => ({ view: "law", request: { model, range: lawRange(model) } }),
  diagram: ({ model, diagram }, widths, limits) => ({
    view: "diagram",
    request: {
      // Along its own parameter the diagram stays what it is: the present value is no part of it.
      model: withValue(limits, model, diagram.parameter, diagram.full[0]),
      parameter: diagram.parameter,
      range: diagram.range,
      window: diagram.window,
      values: Math.min(
        most(limits, "diagram", "values"),
        50 * Math.ceil((widths.diagram || 500) / 100),
      ),
      max_period: diagram.max_period,
    },
  }),
  cycle: (state) => ({ view: "cycle", request: { model: state.model, ...startOf(state) } }),
};

/**
 * Two blocks start from a global stick, others from displacements and velocities.
 * @param {State} state
 */
const startOf = ({ model, d, x, v }) =>
  hasLineMap(model) ? { d } : { x: perBlock(model, x), v: perBlock(model, v) };

/**
 * Slip speeds that show the law's shape: some times the belt's.
 * @param {Record<string, any>} model
 */
const lawRange = (model) => Math.max(0.5, 4 * (model.V || 0));

/** Slots of questions that may take long: they wait until the controls rest. */
export const PATIENT = new Set(["diagram", "basins", "power", "cycle"]);

const OF_LINE = ["locus", "map", "power", "cobweb", "basins", "diagram", "motion"];

/** Slots that have a meaning for a model; those first that need no kernels. @param {State} state */
export const slotsFor = ({ model }) =>
  hasLineMap(model)
    ? ["law", ...OF_LINE]
    : ["law", "motion", "cycle", ...(hasBlocksMap(model) ? ["basins"] : [])];
