/**
 * What the page asks of the server, as functions of the state alone: equal questions are not asked again.
 *
 * @import {State, Question, Limits} from "./types.js"
 */
import {
  hasLineMap,
  hasSpaceMap,
  lawsOf,
  startPoint,
  startState,
  sticksAsOne,
  windowOf,
  withValue,
} from "./model.js";

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
  returns: (state) => ({ view: "returns", request: ofMap(state) }),
  map: (state, widths, limits) => ({
    view: "event_map",
    request: {
      ...ofMap(state),
      window: horizontal(windowOf(state, "map")),
      points: resolution(widths.map, most(limits, "event_map", "points")),
      power: 1,
      max_period: state.max_period,
    },
  }),
  power: (state, widths, limits) => ({
    view: "event_map",
    request: {
      ...ofMap(state),
      window: horizontal(windowOf(state, "power")),
      points: resolution(widths.power, most(limits, "event_map", "points")),
      power: state.power,
      max_period: 0,
    },
  }),
  cobweb: (state) => ({
    view: "cobweb",
    request: { ...ofMap(state), ...startOf(state), n: COBWEB_STEPS },
  }),
  basins: (state) => ({ view: "basins", request: ofMap(state) }),
  motion: (state) => ({
    view: "motion",
    request: { ...ofMap(state), ...startOf(state), t_end: state.t_end, samples: MOTION_SAMPLES },
  }),
  locus: ({ model }) => ({ view: "locus", request: { model } }),
  law: ({ model }, _, limits) => ({
    view: "law",
    request: { model, range: Math.min(most(limits, "law", "range"), lawRange(model)) },
  }),
  diagram: ({ model, diagram, section }, widths, limits) => ({
    view: "diagram",
    request: {
      ...(section ? { section } : {}),
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
  cycle: (state) => ({ view: "cycle", request: { ...ofMap(state), ...startOf(state) } }),
};

/** A model, and where its return map is taken if that is said. @param {State} state */
const ofMap = ({ model, section }) => (section ? { model, section } : { model });

/**
 * Where there is a map of the line the motion starts from a point of it; else from displacements and
 * velocities.
 * @param {State} state
 */
const startOf = (state) =>
  hasLineMap(state) ? { d: startPoint(state) } : startState(state.model, state);

/**
 * Slip speeds that show the law's shape: some times the belts', and the speeds in the laws.
 * @param {Record<string, any>} model
 */
const lawRange = (model) =>
  Math.max(
    0.5,
    ...[model, ...(model.contact ?? [])].map(({ V }) => 4 * Math.abs(V || 0)),
    ...lawsOf(model).map((/** @type {any} */ { law, speed }) => (law === "stribeck" ? 4 * speed : 0)),
  );

/** Slots of questions that may take long: they wait until the controls rest. */
export const PATIENT = new Set(["diagram", "basins", "power", "cycle"]);

const OF_LINE = ["cobweb", "motion", "map", "power", "basins", "diagram"];

/** Slots that have a meaning for a model; those first that need no kernels. @param {State} state */
export function slotsFor(state) {
  const first = sticksAsOne(state.model) ? ["law"] : ["law", "returns"];
  if (hasLineMap(state))
    return [...first, ...(sticksAsOne(state.model) ? ["locus"] : []), ...OF_LINE];
  return [...first, "motion", "cycle", ...(hasSpaceMap(state) ? ["basins"] : [])];
}
