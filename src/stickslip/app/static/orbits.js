/**
 * Breaks and orbits of a map of the line, from its values.
 *
 * Labels that differ enclose a break, which is bisected. Breaks of a power are preimages of the map's;
 * between two of them the power is continuous, so that an orbit beside a jump is not missed.
 *
 * @import {Samples} from "./engine.js"
 * @import {Orbit} from "./types.js"
 *
 * @typedef {{map: (x: ArrayLike<number>) => Samples, itinerary: (x: number) => string}} MapOfLine
 * @typedef {{x: number, value: number, slope: number, label?: bigint}} Point  none: no value
 * @typedef {Point[]} Piece  from one break to the next; monotone between points
 * @typedef {{at: number, left: number, right: number, kind: "jump" | "corner" | "smooth" | "edge"}} Break
 */

const TINY = 1e-11; // of the domain: what is nearer to a break is not looked at
const AGAIN = 1e-7; // of the domain: an orbit that is known
const SAME_VALUE = 1e-6; // of the domain: beside a cusp values differ by a root of rounding
const SAME_SLOPE = 1e-4;
const RESIDUAL = 1e-9; // of an orbit
const STEPS = 60; // more than a bisection takes
const FEWEST = 6; // points between two breaks, however near these are
const MOST = 4000; // breaks of a power; further ones are left out

/** The map at some points. @param {MapOfLine} f @param {ArrayLike<number>} x @returns {Point[]} */
function points(f, x) {
  const { value, slope, label } = f.map(x);
  return Array.from(x, (at, k) => ({
    x: at,
    value: value[k],
    slope: slope[k],
    label: Number.isNaN(value[k]) ? undefined : label[k],
  }));
}

/** The map's powers, up to one. @param {MapOfLine} f @param {ArrayLike<number>} x @param {number} most */
export const iterated = (f, x, most) => [...powers(f, x, most)];

/** The same, one after the other. @returns {Iterable<Samples>} */
function* powers(
  /** @type {MapOfLine} */ f,
  /** @type {ArrayLike<number>} */ x,
  /** @type {number} */ most,
) {
  /** @type {Samples | undefined} */ let before;
  for (let k = 0; k < most; k++) {
    const now = f.map(before?.value ?? x);
    if (before)
      for (let i = 0; i < x.length; i++) {
        now.slope[i] *= before.slope[i];
        now.label[i] = BigInt.asUintN(64, before.label[i] * 0x100000001b3n) ^ now.label[i];
      }
    yield now;
    before = now;
  }
}

/** Pairs of neighbours with different labels, as near as numbers are. @returns {Iterable<[Point, Point]>} */
function* edges(
  /** @type {MapOfLine} */ f,
  /** @type {Point} */ low,
  /** @type {Point} */ high,
) {
  if (low.label === high.label) return;
  const x = 0.5 * (low.x + high.x);
  if (x > low.x && x < high.x) {
    const [middle] = points(f, [x]);
    yield* edges(f, low, middle);
    yield* edges(f, middle, high);
  } else yield [low, high];
}

/** Where a slope changes its sign. @param {(x: number) => Point} at @param {Point} low @param {Point} high */
function turning(at, low, high) {
  for (let k = 0; k < STEPS; k++) {
    const middle = at(0.5 * (low.x + high.x));
    if (middle.slope > 0 === low.slope > 0) low = middle;
    else high = middle;
  }
  return low;
}

/**
 * The map between its breaks. What no sample falls on is not seen.
 * @param {MapOfLine} f @param {ArrayLike<number>} x  ascending, over the domain
 * @returns {Piece[]}
 */
export function pieces(f, x) {
  const known = points(f, x);
  /** @type {Piece[]} */ const found = [[known[0]]];
  for (let k = 1; k < known.length; k++) {
    const [before, after] = [known[k - 1], known[k]];
    for (const [low, high] of edges(f, before, after)) {
      found.at(-1)?.push(low);
      found.push([high]);
    }
    if (before.label === after.label && before.slope * after.slope < 0)
      found.at(-1)?.push(turning((at) => points(f, [at])[0], before, after));
    found.at(-1)?.push(after);
  }
  const width = x[x.length - 1] - x[0];
  return found.filter((piece) => piece[piece.length - 1].x - piece[0].x > TINY * width);
}

/**
 * Breaks of the map, with one-sided values; slopes of cusps are looked at beside them.
 * @param {MapOfLine} f @param {Piece[]} parts @returns {Break[]}
 */
function breaks(f, parts) {
  const between = parts.slice(1).map((piece, k) => [parts[k][parts[k].length - 1], piece[0]]);
  const told = beside(f, parts, between.map(([{ x }]) => x), 1);
  return told.map((one, k) => {
    const [left, right] = between[k].map(({ value }) => value);
    return { ...one, left, right };
  });
}

/** What a power does beside some points. @returns {Break[]} */
function beside(
  /** @type {MapOfLine} */ f,
  /** @type {Piece[]} */ parts,
  /** @type {number[]} */ at,
  /** @type {number} */ power,
) {
  const width = widthOf(parts);
  const sides = at.flatMap((x) => [x - TINY * width, x + TINY * width]);
  const run = iterated(f, sides, power)[power - 1];
  return at.map((x, k) => {
    const [left, right] = run.value.subarray(2 * k, 2 * k + 2);
    const slopes = run.slope.subarray(2 * k, 2 * k + 2);
    return { at: x, left, right, kind: kindOf(left, right, slopes, width) };
  });
}

/** @returns {Break["kind"]} */
function kindOf(
  /** @type {number} */ left,
  /** @type {number} */ right,
  /** @type {Float64Array} */ [before, after],
  /** @type {number} */ width,
) {
  if (Number.isNaN(left + right)) return "edge";
  if (Math.abs(right - left) > SAME_VALUE * width) return "jump";
  const size = Math.max(Math.abs(before), Math.abs(after), 1);
  return Math.abs(after - before) > SAME_SLOPE * size ? "corner" : "smooth";
}

/** @param {Piece[]} parts */
const widthOf = (parts) => (parts.at(-1)?.at(-1)?.x ?? 0) - parts[0][0].x;

/** A root between two points, by Newton's method, halving where it leaves them. */
function root(
  /** @type {(x: number) => Point} */ at,
  /** @type {Point} */ low,
  /** @type {Point} */ high,
) {
  let [a, b, rising] = [low.x, high.x, high.value > 0];
  let x = 0.5 * (a + b);
  for (let k = 0; k < STEPS; k++) {
    const { value, slope } = at(x);
    if (value > 0 === rising) b = x;
    else a = x;
    const next = x - value / slope;
    const to = next > a && next < b ? next : 0.5 * (a + b);
    if (Math.abs(to - x) <= 4e-16 * Math.max(1, Math.abs(x))) break;
    x = to;
  }
  return x;
}

/**
 * Points that lead to a break after some steps, with all points on their way, by their number.
 * @param {MapOfLine} f @param {Piece[]} parts @param {Break[]} known @param {number} most
 */
function ways(f, parts, known, most) {
  const levels = [known.filter(({ kind }) => kind !== "smooth").map(({ at }) => [at])];
  for (let all = 0; levels.length < most && all < MOST; all += levels[levels.length - 1].length)
    levels.push(
      levels[levels.length - 1].flatMap((way) =>
        preimages(f, parts, way[0]).map((x) => [x, ...way]),
      ),
    );
  return levels;
}

/** @param {MapOfLine} f @param {Piece[]} parts @param {number} y */
function preimages(f, parts, y) {
  const off = (/** @type {Point} */ point) => ({ ...point, value: point.value - y });
  const at = (/** @type {number} */ x) => off(points(f, [x])[0]);
  return parts.flatMap((piece) =>
    piece.slice(1).flatMap((after, k) => {
      const before = piece[k];
      if (Number.isNaN(before.value) || before.value > y === after.value > y) return [];
      return [root(at, off(before), off(after))];
    }),
  );
}

/**
 * Breaks of a power, with one-sided values.
 * @param {MapOfLine} f @param {Piece[]} parts @param {number} power
 */
export function breaksOfPower(f, parts, power) {
  const known = breaks(f, parts);
  if (power === 1) return known;
  const heads = ways(f, parts, known, power).flatMap((level) => level.map(([x]) => x));
  return beside(f, parts, heads, power);
}

/**
 * Orbits, more with each longer period; at last those through a jump, too.
 * @param {MapOfLine} f @param {Piece[]} parts @param {number} most  of the periods
 * @returns {Iterable<Orbit[]>}
 */
export function* orbits(f, parts, most) {
  const known = breaks(f, parts);
  const levels = ways(f, parts, known, most);
  const cuts = levels.flatMap((level) => level.map(([x]) => x));
  const grid = between(parts, cuts);
  const again = AGAIN * widthOf(parts);
  /** @type {Orbit[]} */ const found = [];
  const isKnown = (/** @type {number} */ x) =>
    found.some((orbit) => orbit.points.some((point) => Math.abs(point - x) < again));
  let n = 0;
  for (const { value, slope } of powers(f, grid.flat(), most)) {
    n += 1;
    const at = (/** @type {number} */ x) => {
      const run = iterated(f, [x], n)[n - 1];
      return { x, value: run.value[0] - x, slope: run.slope[0] - 1 };
    };
    let i = 0;
    for (const xs of grid) {
      const here = xs.map((x) => ({ x, value: value[i] - x, slope: slope[i++] - 1 }));
      for (let j = 1; j < here.length; j++)
        for (const x of roots(at, here[j - 1], here[j], again / 8))
          if (!isKnown(x) && Math.abs(at(x).value) < RESIDUAL) found.push(orbitFrom(f, x, n));
    }
    yield [...found];
  }
  yield [...found, ...throughJumps(known, levels)];
}

/** Points between breaks of a power. @param {Piece[]} parts @param {number[]} cuts @returns {number[][]} */
function between(parts, cuts) {
  const aside = TINY * widthOf(parts);
  const xs = parts.flatMap((piece) => piece.map(({ x }) => x));
  const ends = [xs[0] - aside, ...cuts.sort((a, b) => a - b), xs[xs.length - 1] + aside];
  let k = 0;
  return ends.slice(1).flatMap((end, i) => {
    const [low, high] = [ends[i] + aside, end - aside];
    if (!(high - low > aside)) return [];
    while (k < xs.length && xs[k] <= low) k++;
    const inner = [];
    while (k < xs.length && xs[k] < high) inner.push(xs[k++]);
    const some = inner.length >= FEWEST ? inner : within(low, high);
    return [[low, ...some, high]];
  });
}

/** @param {number} low @param {number} high */
const within = (low, high) =>
  Array.from({ length: FEWEST }, (_, k) => low + ((high - low) * (k + 1)) / (FEWEST + 1));

/** Roots between two points of a function whose slope grows or falls there. @returns {Iterable<number>} */
function* roots(
  /** @type {(x: number) => Point} */ at,
  /** @type {Point} */ low,
  /** @type {Point} */ high,
  /** @type {number} */ aside,
) {
  const step = high.x - low.x;
  if (Number.isNaN(low.value + high.value) || step < aside) return;
  if (low.value > 0 !== high.value > 0) {
    const x = root(at, low, high);
    yield x;
    // Beside one of three the signs are those of the other two.
    const [before, after] = [at(x - aside), at(x + aside)];
    if (before.value > 0 !== low.value > 0) yield* roots(at, low, before, aside);
    if (after.value > 0 !== high.value > 0) yield* roots(at, after, high, aside);
  } else if (reaches(low, step) && reaches(high, -step)) {
    const middle = at(0.5 * (low.x + high.x));
    yield* roots(at, low, middle, aside);
    yield* roots(at, middle, high, aside);
  }
}

/** Whether a function comes to 0 within a step, if it goes on as it begins. @param {Point} from @param {number} step */
const reaches = ({ value, slope }, step) => value > 0 === value + slope * step < 0;

/** @param {MapOfLine} f @param {number} x @param {number} period @returns {Orbit} */
function orbitFrom(f, x, period) {
  const runs = iterated(f, Float64Array.of(x), period);
  const all = [x, ...runs.slice(0, -1).map(({ value }) => value[0])];
  const least = all.indexOf(Math.min(...all));
  const points = [...all.slice(least), ...all.slice(0, least)];
  const multiplier = runs[period - 1].slope[0];
  const stable = Math.abs(multiplier) < 1;
  const kind = stable ? "stable" : "unstable";
  const itinerary = points.map((point) => f.itinerary(point));
  return { period, points, multiplier, stable, kind, itinerary };
}

/** From inside a jump back to it. @param {Break[]} known @param {number[][][]} levels @returns {Orbit[]} */
function throughJumps(known, levels) {
  const jumps = known.filter(({ kind }) => kind === "jump");
  return levels.flatMap((level, k) =>
    level.flatMap((way) => {
      const jump = jumps.find(({ at }) => at === way[k]);
      if (!jump || way[0] > jump.left === way[0] > jump.right) return [];
      const points = [jump.at, ...way.slice(0, -1)];
      const kind = "infinitely unstable";
      return [{ period: k + 1, points, multiplier: null, stable: false, kind }];
    }),
  );
}
