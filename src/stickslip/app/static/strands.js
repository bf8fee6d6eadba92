/**
 * Curves of orbits that are known at some values of a parameter only.
 *
 * @import {Numbers} from "./types.js"
 */
import { span } from "./numbers.js";

const REACH = 0.08; // of what all points span: how far a point may move from one value to the next

/**
 * @typedef {{xs: number[], ys: number[]}} Strand  a curve of one point of an orbit
 * @typedef {{xs: number[], points: number[][]}} Curve  an orbit over the parameter
 */

/** @type {Strand[]} */
export const noStrands = [];

/**
 * @param {Record<string, Numbers>} rows  `value`, `d` and `period` of each point, orbit after orbit
 * @param {{value: number, points: number[]}[]} ends  where orbits may end between two values
 * @returns {Strand[]}
 */
export function strands({ value, d, period }, ends) {
  /** @type {Map<number, number[][]>} */ const columns = new Map();
  for (let k = 0; k < d.length; k += period[k]) {
    const orbit = [...d.slice(k, k + period[k])];
    columns.set(value[k], [...(columns.get(value[k]) ?? []), orbit]);
  }
  const [low, high] = span(d);
  const reach = REACH * (high - low);
  const curves = linked(columns, reach);
  const at = [...columns.keys()].sort((a, b) => a - b);
  for (const { xs, points } of curves) {
    const [first, last] = [at.indexOf(xs[0]), at.indexOf(xs[xs.length - 1])];
    const before = meeting(ends, at[first - 1], xs[0], points[0], reach);
    const after = meeting(ends, xs[xs.length - 1], at[last + 1], points[points.length - 1], reach);
    xs.splice(0, 0, ...before.map(({ at }) => at));
    points.splice(0, 0, ...before.map(({ orbit }) => orbit));
    xs.push(...after.map(({ at }) => at));
    points.push(...after.map(({ orbit }) => orbit));
  }
  return curves.flatMap(({ xs, points }) =>
    points[0].map((_, k) => ({ xs, ys: points.map((orbit) => orbit[k]) })),
  );
}

/**
 * Orbits at one value go on as those that are nearest at the next, if these think so, too.
 * @param {Map<number, number[][]>} columns @param {number} reach
 */
function linked(columns, reach) {
  /** @type {Curve[]} */ const done = [];
  /** @type {Curve[]} */ let open = [];
  for (const [x, orbits] of [...columns].sort(([a], [b]) => a - b)) {
    const ends = open.map(({ points }) => points[points.length - 1]);
    const far = ends.map((end) => orbits.map((orbit) => turned(orbit, end).far));
    const next = orbits.map((orbit, j) => {
      const i = least(far.map((row) => row[j]));
      const mutual = i >= 0 && far[i][j] <= reach && least(far[i]) === j;
      if (!mutual) return { xs: [x], points: [orbit] };
      open[i].xs.push(x);
      open[i].points.push(turned(orbit, ends[i]).points);
      return open[i];
    });
    done.push(...open.filter((curve) => !next.includes(curve)));
    open = next;
  }
  return [...done, ...open];
}

/** An orbit, begun at the point at which it fits another best. @param {number[]} orbit @param {number[]} to */
function turned(orbit, to) {
  let best = { far: Infinity, points: orbit };
  if (orbit.length !== to.length) return best;
  for (let turn = 0; turn < orbit.length; turn++) {
    const points = [...orbit.slice(turn), ...orbit.slice(0, turn)];
    const far = Math.max(...points.map((point, k) => Math.abs(point - to[k])));
    if (far < best.far) best = { far, points };
  }
  return best;
}

/** Index of the least; -1 of none. @param {number[]} values */
const least = (values) => values.indexOf(Math.min(...values));

/** The bifurcation between two values that an orbit comes to, if there is one. */
function meeting(
  /** @type {{value: number, points: number[]}[]} */ ends,
  /** @type {number} */ low,
  /** @type {number} */ high,
  /** @type {number[]} */ orbit,
  /** @type {number} */ reach,
) {
  return ends
    .filter(({ value, points }) => value > low && value < high && points.length >= orbit.length)
    .map(({ value, points }) => ({
      at: value,
      orbit: orbit.map((d) => points[least(points.map((point) => Math.abs(point - d)))]),
    }))
    .filter((met) => met.orbit.every((point, k) => Math.abs(point - orbit[k]) <= reach))
    .slice(0, 1);
}
