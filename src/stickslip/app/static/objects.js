/**
 * Orbits, breakpoints and bifurcations as objects: named, placed, told, gone to. Marks, tips and the
 * table are of these.
 *
 * @import {App} from "./app.js"
 * @import {Orbit} from "./types.js"
 * @import {Plot} from "./plot.js"
 */
import { named } from "./marks.js";
import { inWordsOf } from "./model.js";
import { modeBar } from "./modes.js";
import { short, spelled } from "./numbers.js";
import { alike } from "./shipped.js";

/** Where a mechanism goes into numbers, too long for a sentence. */
export const AWAY = /(, X|:| near X)/;
const NEAR = 8; // pixels within which the pointer means a mark
const BESIDE = 1 / 400; // of the domain, or of the range: just before, just after

/**
 * @typedef {Orbit & {name: string}} Named
 *
 * @typedef {object} Thing
 * @property {string} key
 * @property {"orbit" | "break" | "bifurcation"} sort
 * @property {string} name
 * @property {string} what  in words
 * @property {number} at  d, or the diagram's parameter
 * @property {string} along  which of them
 * @property {number | null} factor  multiplier
 * @property {string} why
 * @property {string[]} modes  itineraries
 * @property {any} of
 * @property {(side: number) => void} go  there (0), just before (-1), just after (1)
 */

/** Infinitely unstable: through a jump. There are many. @param {{kind: string}} orbit */
export const isThrough = ({ kind }) => kind === "infinitely unstable";

/**
 * Orbits of the present map; until they are known those of the one before (`old`). A search
 * completes what follows from the map before. Nothing brings the present ones where they are `past`.
 * @param {App} app
 * @returns {{orbits: Named[], old: boolean, past: boolean, searched: boolean, complete: boolean}}
 */
export function orbitsOf(app) {
  const answer = app.answers.get("map");
  const now = answer?.parts.findLast((part) => part.data.orbits);
  // A whole answer without them was not asked for any; one that broke off gets no more.
  const ended = answer?.done || answer?.error || answer?.cancelled;
  const before = ended ? undefined : answer?.before.findLast((part) => part.data.orbits);
  /** @type {Orbit[]} */
  const orbits = [...((now ?? before)?.data.orbits ?? [])];
  // Those that follow from the last map lack what only a search finds.
  const followed = now?.data.part_name === "followed";
  if (followed) orbits.push(...(before?.data.orbits ?? []).filter(isThrough));
  const complete = now?.data.complete ?? true;
  const comes = app.connection.running.has("map");
  const past = !comes && !(answer && alike(answer.question, app.question("map")));
  return { orbits: named(orbits), old: !now, past, searched: Boolean(now) && !followed, complete };
}

/** @param {App} app @param {Named} orbit @returns {Thing} */
export function orbitThing(app, orbit) {
  const { name, points, period, kind, multiplier, itinerary } = orbit;
  return {
    key: `orbit ${period} ${points[0]}`,
    sort: "orbit",
    name,
    what: `${kind}, period ${period}`,
    at: points[0],
    along: "d",
    factor: multiplier,
    why: points.map((point) => short(point, 6)).join(", "),
    modes: itinerary ?? [],
    of: orbit,
    go: (side) => startAt(app, points[0], side),
  };
}

/** @param {App} app @returns {Thing[]} */
export function breakThings(app) {
  const values = app.answers.get("map")?.parts.findLast((part) => part.arrays.x)?.data;
  return (values?.breakpoints ?? []).map((/** @type {any} */ one) => ({
    ...plain(app, "break", one.kind, one.at, "d", one),
    what: `breakpoint, from ${short(one.left)} to ${short(one.right)}`,
    modes: one.itineraries ?? [],
    go: (/** @type {number} */ side) => startAt(app, one.at, side),
  }));
}

/** @param {App} app @returns {Thing[]} */
export function bifurcationThings(app) {
  const part = app.answers.get("diagram")?.parts.find(({ data }) => data.bifurcations);
  const { parameter, range } = app.state.diagram;
  return (part?.data.bifurcations ?? []).map((/** @type {any} */ one) => ({
    ...plain(app, "bifurcation", one.short, one.value, parameter, one),
    what: `${one.kind.replaceAll("_", " ")}${one.period ? `, period ${one.period}` : ""}`,
    go: (/** @type {number} */ side) =>
      app.goTo(one.value + side * BESIDE * (range[1] - range[0]), one.points[0]),
  }));
}

/** What has a place and a mechanism, but no multiplier. */
const plain = (
  /** @type {App} */ app,
  /** @type {Thing["sort"]} */ sort,
  /** @type {string} */ name,
  /** @type {number} */ at,
  /** @type {string} */ along,
  /** @type {any} */ of,
) => {
  const why = inWordsOf(app.state.model, spelled(of.mechanism ?? ""));
  return { key: `${sort} ${name} ${at}`, sort, name, at, along, factor: null, why, modes: [], of };
};

/** @param {App} app @param {number} d @param {number} side */
function startAt(app, d, side) {
  const [low, high] = app.domain() ?? [-1, 1];
  app.startAt(d + side * BESIDE * (high - low));
}

/** What a thing is, for the tip. @param {Thing} thing @returns {(string | Node)[]} */
export function told({ sort, name, what, at, factor, why, modes }) {
  const lines = [sort === "orbit" ? `${name}: ${what}` : `${name}: ${what} at ${short(at, 10)}`];
  if (factor !== null) lines.push(`multiplier ${short(factor, 6)}`);
  return [
    [...lines, why].filter(Boolean).join("\n"),
    ...modes.flatMap((one) => ["\n", modeBar(one)]),
  ];
}

/**
 * The thing whose mark is under the pointer; orbits come before breaks and what goes through jumps.
 * @param {Plot} plot @param {number} x @param {number} y
 * @param {{thing: Thing, spots: number[][]}[]} marks  y is NaN for a line over the whole height
 */
export function under(plot, x, y, marks) {
  const [px, py] = [plot.x(x), plot.y(y)];
  let [best, least] = [/** @type {Thing | null} */ (null), NEAR];
  for (const { thing, spots } of marks) {
    const behind = thing.sort === "break" || isThrough(thing.of) ? NEAR / 2 : 0;
    for (const [ax, ay] of spots) {
      const dy = Number.isNaN(ay) ? 0 : plot.y(ay) - py;
      const far = behind + Math.hypot(plot.x(ax) - px, dy);
      if (far < least) [best, least] = [thing, far];
    }
  }
  return best;
}
