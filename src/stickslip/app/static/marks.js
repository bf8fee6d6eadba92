/**
 * Marks of points, told apart by shape as well as by colour, and labels that do not collide.
 *
 * @import {Plot} from "./plot.js"
 * @import {Numbers, Orbit} from "./types.js"
 */
import { SANS, colors } from "./theme.js";

/** @typedef {"disc" | "ring" | "square" | "cross" | "up" | "right" | "diamond" | "plus"} Shape */

/** @type {Record<Shape, (c: CanvasRenderingContext2D, x: number, y: number, r: number) => void>} */
const OUTLINES = {
  disc: (c, x, y, r) => c.arc(x, y, r, 0, 2 * Math.PI),
  ring: (c, x, y, r) => c.arc(x, y, r, 0, 2 * Math.PI),
  square: (c, x, y, r) => c.rect(x - r, y - r, 2 * r, 2 * r),
  cross: (c, x, y, r) => strokes(c, [x - r, y - r, x + r, y + r, x - r, y + r, x + r, y - r]),
  plus: (c, x, y, r) => strokes(c, [x - r, y, x + r, y, x, y - r, x, y + r]),
  up: (c, x, y, r) => corners(c, [x, y - r, x + r, y + r, x - r, y + r]),
  right: (c, x, y, r) => corners(c, [x + r, y, x - r, y + r, x - r, y - r]),
  diamond: (c, x, y, r) => corners(c, [x, y - r, x + r, y, x, y + r, x - r, y]),
};

/** @param {CanvasRenderingContext2D} c @param {number[]} at */
function strokes(c, at) {
  for (let k = 0; k < at.length; k += 4) {
    c.moveTo(at[k], at[k + 1]);
    c.lineTo(at[k + 2], at[k + 3]);
  }
}

/** @param {CanvasRenderingContext2D} c @param {number[]} at */
function corners(c, at) {
  for (let k = 0; k < at.length; k += 2) c.lineTo(at[k], at[k + 1]);
  c.closePath();
}

/**
 * @param {Plot} plot @param {Shape} shape @param {number} x @param {number} y  in units of the data
 * @param {{color?: string, size?: number}} [look]
 */
export function mark(plot, shape, x, y, { color = colors().ink, size = 4 } = {}) {
  const [px, py] = [plot.x(x), plot.y(y)];
  if (Number.isNaN(px + py)) return;
  const { context } = plot;
  const thin = shape === "cross" || shape === "plus";
  const open = shape === "ring" || shape === "square";
  context.beginPath();
  OUTLINES[shape](context, px, py, size);
  if (size > 3) {
    context.lineWidth = thin ? 3.6 : open ? 3.4 : 1.2;
    context.strokeStyle = colors().panel; // a rim that keeps marks apart from lines
    context.stroke();
  }
  if (!thin) {
    context.fillStyle = open ? colors().panel : color;
    context.fill();
  }
  if (thin || open) {
    context.lineWidth = size > 3 ? 1.6 : 1.1;
    context.strokeStyle = color;
    context.stroke();
  }
}

/** Bifurcations by their short names: mark, colour, words. @type {Record<string, [Shape, string, string]>} */
export const BIFURCATIONS = {
  BC: ["diamond", "purple", "border collision: an orbit meets a break of the map"],
  PD: ["disc", "green", "flip (period doubling): multiplier −1"],
  LP: ["right", "blue", "fold: a stable and an unstable orbit meet"],
  TC: ["up", "ink", "transcritical: two orbits exchange stability"],
  PF: ["up", "ink", "pitchfork: an orbit splits in three"],
  CR: ["plus", "orange", "boundary crisis: chaos meets an unstable orbit and ends"],
  IC: ["plus", "vermillion", "interior crisis: chaos grows at once"],
  BM: ["ring", "sky", "band merging: bands of chaos become one"],
  EG: ["cross", "ink", "enters a gap: motions stop coming back to a stick of both blocks"],
};

/** How an orbit is marked. @param {{stable: boolean, kind: string}} orbit @returns {Shape} */
export const orbitShape = ({ stable, kind }) =>
  kind === "infinitely unstable" ? "cross" : stable ? "disc" : "square";

/** The first of a period in ascending order has no letter. */
const LETTERS = ["", ..."bcdefghijklmnopqrstuvwxyz"];

/**
 * Orbits with names as in the paper: S and the period of a stable one; U and a number of any other,
 * in the order of periods, then of places, those through a jump last.
 * @param {Orbit[]} orbits
 */
export function named(orbits) {
  const key = (/** @type {Orbit} */ { kind, period, points }) =>
    /** @type {const} */ ([Number(kind === "infinitely unstable"), period, Math.min(...points)]);
  const keys = new Map(orbits.map((orbit) => [orbit, key(orbit)]));
  /** @param {Orbit} a @param {Orbit} b */
  const order = (a, b) => {
    const [one, other] = [keys.get(a) ?? [], keys.get(b) ?? []];
    return one.map((part, k) => part - other[k]).find(Boolean) ?? 0;
  };
  const inOrder = [...orbits].sort(order);
  const unstable = inOrder.filter(({ stable }) => !stable);
  return orbits.map((orbit) => {
    if (!orbit.stable) return { ...orbit, name: `U${unstable.indexOf(orbit) + 1}` };
    const alike = inOrder.filter(({ stable, period }) => stable && period === orbit.period);
    return { ...orbit, name: `S${orbit.period}${LETTERS[alike.indexOf(orbit)]}` };
  });
}

/** How far from its point a text may stand, and whether off all lines: the first that has room. */
const PLACES = /** @type {const} */ ([
  [1, true],
  [2, true],
  [1, false],
  [2, false],
  [3.4, false],
]);

/** Places texts beside points, further off with a line to them; those without room are left out. */
export class Labels {
  /** @param {Plot} plot */
  constructor(plot) {
    this.plot = plot;
    /** @type {number[][]} */ this.taken = [];
    /** @type {number[][]} */ this.lines = [];
  }

  /** Keep a point free of text. @param {number} x @param {number} y @param {number} [r] */
  avoid(x, y, r = 5) {
    this.taken.push(this.#about(x, y, r));
  }

  /** Keep a curve free of text, if there is room elsewhere. @param {Numbers} xs @param {Numbers} ys */
  avoidLine(xs, ys) {
    for (let k = 0; k < xs.length; k++) this.lines.push(this.#about(xs[k], ys[k], 1));
  }

  /** @param {number} x @param {number} y @param {number} r */
  #about(x, y, r) {
    const [px, py] = [this.plot.x(x), this.plot.y(y)];
    return [px - r, py - r, px + r, py + r];
  }

  /** @param {string} text @param {number} x @param {number} y @param {string} [color] */
  place(text, x, y, color = colors().ink) {
    const { context } = this.plot;
    const [px, py] = [this.plot.x(x), this.plot.y(y)];
    context.font = `600 11px ${SANS}`;
    const width = context.measureText(text).width;
    for (const [far, clear] of PLACES) {
      for (const [dx, dy] of [
        [8 * far, -8 * far],
        [-8 * far - width, -8 * far],
        [8 * far, 8 + 8 * far],
        [-8 * far - width, 8 + 8 * far],
        [-width / 2, -11 * far],
        [-width / 2, 8 + 11 * far],
      ]) {
        const box = [px + dx - 2, py + dy - 10, px + dx + width + 2, py + dy + 3];
        if (!this.#free(box, clear)) continue;
        this.taken.push(box);
        if (far > 1) this.#leader(px, py, box, color);
        return this.#write(text, px + dx, py + dy, color);
      }
    }
  }

  /** @param {number[]} box @param {boolean} clear  of lines, too */
  #free(box, clear) {
    const { left, right, top, bottom } = this.plot;
    const inside = box[0] > left && box[2] < right && box[1] > top && box[3] < bottom;
    const others = clear ? [...this.taken, ...this.lines] : this.taken;
    return inside && !others.some((other) => meet(box, other));
  }

  /** @param {number} px @param {number} py @param {number[]} box @param {string} color */
  #leader(px, py, [left, top, right, bottom], color) {
    const { context } = this.plot;
    context.beginPath();
    context.moveTo(px, py);
    context.lineTo(Math.min(right, Math.max(left, px)), Math.min(bottom, Math.max(top, py)));
    context.lineWidth = 0.8;
    context.strokeStyle = color;
    context.stroke();
  }

  /** @param {string} text @param {number} px @param {number} py @param {string} color */
  #write(text, px, py, color) {
    const { context } = this.plot;
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    context.lineWidth = 3;
    context.strokeStyle = colors().panel;
    context.strokeText(text, px, py);
    context.fillStyle = color;
    context.fillText(text, px, py);
  }
}

/** @param {number[]} a @param {number[]} b */
const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
