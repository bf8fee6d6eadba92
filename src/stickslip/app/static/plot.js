/**
 * A plane with axes on two canvases: what changes with the data below, what moves above.
 *
 * @import {Box} from "./types.js"
 */
import { element } from "./dom.js";
import { attachGestures } from "./gestures.js";
import { MATH, SANS, colors } from "./theme.js";
import { ticks } from "./numbers.js";

/**
 * @typedef {object} Options
 * @property {string} name  for those who cannot see it
 * @property {string} xlabel
 * @property {string} ylabel
 * @property {boolean} [equal]  one scale on both axes
 * @property {boolean} [square]  a square frame: where both ranges agree the diagonal has 45 degrees
 * @property {Plot} [above]  the plot whose horizontal axis this one shares
 * @property {boolean} [bare]  no vertical axis
 * @property {boolean} [empty]  no axes at all, the whole area is for drawing
 * @property {number} [left]  width left of the frame
 *
 * @typedef {string | (string | Node)[] | null} Tip
 *
 * @typedef {{color?: string, width?: number, dash?: number[], alpha?: number}} Stroke
 */

const TOP = 8;
const RIGHT = 12;
const BOTTOM = 37;

export class Plot {
  /** @param {HTMLElement} host @param {Options} options */
  constructor(host, options) {
    this.options = options;
    const role = options.empty ? { role: "img" } : { role: "application", tabindex: "0" };
    const name = { ...role, "aria-roledescription": "plot", "aria-label": options.name };
    /** @type {HTMLCanvasElement} */
    this.base = element("canvas", { class: "plot-base", "aria-hidden": "true" });
    /** @type {HTMLCanvasElement} */
    this.over = element("canvas", { class: "plot-over", ...name });
    this.tip = element("div", { class: "tip", role: "status", hidden: true });
    this.box = element("div", { class: "zoom-box", hidden: true });
    this.host = host;
    host.classList.add("plot");
    host.append(this.base, this.over, this.box, this.tip);
    /** What is asked for. @type {Box} */ this.view = [0, 1, 0, 1];
    /** What is shown: with equal scales more. @type {Box} */ this.shown = this.view;
    /** @type {number[]} */ this.marked = [];
    this.paint = () => {};
    this.paintOver = () => {};
    /** Beside the frame. */
    this.paintMargin = () => {};
    /** @type {(x: number, y: number) => void} */ this.onclick = () => {};
    /** @type {(x: number, y: number) => Tip} */ this.onhover = () => null;
    /** @type {((view: Box) => void) | null} */ this.onzoom = null;
    /** @type {() => void} */ this.onreset = () => {};
    /** From where the arrow keys go on, if they do not move the view. @type {(() => number) | null} */
    this.held = null;
    /** @type {(x: number, y: number) => (((x: number, y: number) => void) | null)} */ this.grab =
      () => null;
    /** @type {() => void} */ this.onresize = () => {};
    this.pending = 0;
    this.dirty = false;
    this.width = this.height = 0; // in units of which the screen shows `scale` pixels
    this.scale = 1;
    this.ratio = 1;
    this.left = this.right = this.top = this.bottom = this.gutter = 0;
    this.xTicks = this.yTicks = ticks(0, 1, 2);
    this.context = /** @type {CanvasRenderingContext2D} */ (this.base.getContext("2d"));
    /** The plot that shares its horizontal axis. @type {Plot | null} */ this.below = null;
    if (options.above) options.above.below = this;
    attachGestures(this);
    new ResizeObserver(() => this.#resize()).observe(host);
    this.#resize();
  }

  #resize() {
    const { clientWidth, clientHeight } = this.host;
    this.scale = Number(getComputedStyle(this.host).getPropertyValue("--scale")) || 1;
    const [width, height] = [clientWidth / this.scale, clientHeight / this.scale];
    if (!width || !height || (width === this.width && height === this.height)) return;
    this.width = width;
    this.height = height;
    this.ratio = this.scale * Math.max(1, Math.min(3, devicePixelRatio || 1));
    for (const canvas of [this.base, this.over]) {
      canvas.width = Math.round(width * this.ratio);
      canvas.height = Math.round(height * this.ratio);
    }
    this.redraw();
    this.below?.redraw();
    this.onresize();
  }

  /**
   * Drawn anew is what has changed: a frame with little to draw is there sooner.
   * @param {Box} view
   * @param {...number} marked  what is marked above, but for what moves with the motion
   */
  setView(view, ...marked) {
    const same = view.every((end, k) => end === this.view[k]);
    const still = same && String(marked) === String(this.marked);
    [this.view, this.marked] = [view, marked];
    if (!same) this.redraw();
    else if (!still) this.redrawOver();
  }

  redraw() {
    this.dirty = true;
    this.redrawOver();
  }

  redrawOver() {
    this.pending ||= requestAnimationFrame(() => this.#draw());
  }

  #draw() {
    this.pending = 0;
    if (!this.width) return;
    if (this.dirty) {
      this.dirty = false;
      this.context = this.#clear(this.base);
      this.layOut();
      this.#axes();
      this.paintMargin();
      this.#inside(this.paint);
      this.host.dispatchEvent(new CustomEvent("drawn", { bubbles: true }));
    }
    this.context = this.#clear(this.over);
    this.#inside(this.paintOver);
  }

  /** @param {HTMLCanvasElement} canvas */
  #clear(canvas) {
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, this.width, this.height);
    return context;
  }

  /** @param {() => void} paint */
  #inside(paint) {
    const context = this.context;
    context.save();
    context.beginPath();
    context.rect(this.left, this.top, this.right - this.left, this.bottom - this.top);
    context.clip();
    paint();
    context.restore();
  }

  /** The frame in pixels, and the range shown. */
  layOut() {
    const { equal, bare, empty, left, square, above } = this.options;
    if (empty) {
      [this.left, this.right, this.top, this.bottom] = [0, this.width, 0, this.height];
      return;
    }
    this.top = TOP;
    this.right = this.width - RIGHT;
    this.bottom = this.height - BOTTOM;
    this.shown = this.view;
    this.left = this.gutter = left ?? (bare ? RIGHT : this.#labelWidth() + 30);
    if (square) this.#square();
    if (above?.width === this.width) {
      above.layOut();
      [this.left, this.right] = [above.left, above.right];
    }
    if (equal) this.shown = this.#widened();
    this.yTicks = ticks(this.shown[2], this.shown[3], Math.max(3, (this.bottom - this.top) / 32));
    this.xTicks = ticks(this.shown[0], this.shown[1], Math.max(3, (this.right - this.left) / 68));
  }

  /** Take away what is wider or higher than a square. */
  #square() {
    const side = Math.min(this.right - this.left, this.bottom - this.top);
    this.left += Math.floor((this.right - this.left - side) / 2);
    this.right = this.left + side;
    this.bottom = this.top + side;
  }

  #labelWidth() {
    const { labels } = ticks(
      this.view[2],
      this.view[3],
      Math.max(3, (this.bottom - this.top) / 32),
    );
    this.context.font = `11px ${SANS}`;
    return Math.ceil(Math.max(20, ...labels.map((text) => this.context.measureText(text).width)));
  }

  /** @returns {Box} */
  #widened() {
    const [x0, x1, y0, y1] = this.view;
    const wide = (x1 - x0) / (this.right - this.left);
    const high = (y1 - y0) / (this.bottom - this.top);
    const scale = Math.max(wide, high);
    const [halfX, halfY] = [
      (scale * (this.right - this.left)) / 2,
      (scale * (this.bottom - this.top)) / 2,
    ];
    const [cx, cy] = [(x0 + x1) / 2, (y0 + y1) / 2];
    return [cx - halfX, cx + halfX, cy - halfY, cy + halfY];
  }

  #axes() {
    const { context, left, right, top, bottom } = this;
    if (this.options.empty) return;
    const of = colors();
    context.lineWidth = 1;
    context.strokeStyle = of.grid;
    context.beginPath();
    for (const value of this.xTicks.values) this.#edge(this.x(value), top, this.x(value), bottom);
    if (!this.options.bare) {
      for (const value of this.yTicks.values) this.#edge(left, this.y(value), right, this.y(value));
    }
    context.stroke();
    context.strokeStyle = of.frame;
    context.strokeRect(
      Math.round(left) + 0.5,
      Math.round(top) + 0.5,
      Math.round(right - left),
      Math.round(bottom - top),
    );
    this.#labels();
  }

  /** A line on whole pixels. */
  #edge(
    /** @type {number} */ x0,
    /** @type {number} */ y0,
    /** @type {number} */ x1,
    /** @type {number} */ y1,
  ) {
    this.context.moveTo(Math.round(x0) + 0.5, Math.round(y0) + 0.5);
    this.context.lineTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
  }

  #labels() {
    const { context, left, right, top, bottom } = this;
    const of = colors();
    context.font = `11px ${SANS}`;
    context.fillStyle = of.muted;
    context.textAlign = "center";
    context.textBaseline = "top";
    this.xTicks.values.forEach((value, k) => {
      const half = context.measureText(this.xTicks.labels[k]).width / 2;
      const at = Math.min(this.x(value), this.width - half - 1);
      context.fillText(this.xTicks.labels[k], at, bottom + 5);
    });
    context.textAlign = "right";
    context.textBaseline = "middle";
    if (!this.options.bare) {
      this.yTicks.values.forEach((value, k) => {
        const at = Math.max(top + 5, Math.min(this.y(value), bottom - 4));
        context.fillText(this.yTicks.labels[k], left - 6, at);
      });
    }
    const { xlabel, ylabel } = this.options;
    const offset = this.xTicks.offset ? `(${this.xTicks.offset})` : "";
    mathText(context, xlabel, (left + right) / 2, bottom + BOTTOM - 6, of.ink, offset);
    if (this.options.bare || !ylabel) return;
    context.save();
    context.translate(left - this.gutter + 11, (top + bottom) / 2);
    context.rotate(-Math.PI / 2);
    mathText(context, ylabel, 0, 3, of.ink, this.yTicks.offset ? `(${this.yTicks.offset})` : "");
    context.restore();
  }

  // --- from data to pixels and back ----------------------------------------------------------

  /** @param {number} value */
  x(value) {
    return (
      this.left +
      ((value - this.shown[0]) / (this.shown[1] - this.shown[0])) * (this.right - this.left)
    );
  }

  /** @param {number} value */
  y(value) {
    return (
      this.bottom -
      ((value - this.shown[2]) / (this.shown[3] - this.shown[2])) * (this.bottom - this.top)
    );
  }

  /** @param {number} px */
  dataX(px) {
    return (
      this.shown[0] +
      ((px - this.left) / (this.right - this.left)) * (this.shown[1] - this.shown[0])
    );
  }

  /** @param {number} py */
  dataY(py) {
    return (
      this.shown[2] +
      ((this.bottom - py) / (this.bottom - this.top)) * (this.shown[3] - this.shown[2])
    );
  }

  // --- what the views draw with --------------------------------------------------------------

  /** @param {Stroke} stroke */
  #pen({ color, width = 1.25, dash = [], alpha = 1 }) {
    const { context } = this;
    context.strokeStyle = color ?? colors().ink;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.globalAlpha = alpha;
    context.lineJoin = "round";
  }

  /**
   * A line through points; it breaks where a coordinate is no number, or where `same` says so.
   * @param {ArrayLike<number>} xs @param {ArrayLike<number>} ys @param {Stroke} [stroke]
   * @param {number} [from] @param {number} [to]
   */
  line(xs, ys, stroke = {}, from = 0, to = xs.length) {
    this.#pen(stroke);
    const { context } = this;
    context.beginPath();
    let down = false;
    for (let k = from; k < to; k++) {
      const [px, py] = [this.x(xs[k]), this.y(ys[k])];
      if (Number.isNaN(px + py)) down = false;
      else if (down) context.lineTo(px, py);
      else context.moveTo(px, py);
      down = !Number.isNaN(px + py);
    }
    context.stroke();
    context.globalAlpha = 1;
    context.setLineDash([]);
  }

  /**
   * @param {number} x0
   * @param {number} y0
   * @param {number} x1
   * @param {number} y1
   * @param {Stroke} [stroke]
   */
  segment(x0, y0, x1, y1, stroke = {}) {
    this.line([x0, x1], [y0, y1], stroke);
  }

  /** A line over the whole height. @param {number} x @param {Stroke} [stroke] */
  vertical(x, stroke = {}) {
    this.segment(x, this.shown[2], x, this.shown[3], stroke);
  }

  /** A line over the whole width. @param {number} y @param {Stroke} [stroke] */
  horizontal(y, stroke = {}) {
    this.segment(this.shown[0], y, this.shown[1], y, stroke);
  }

  /** @param {number[][]} corners @param {string} color @param {number} [alpha] */
  polygon(corners, color, alpha = 1) {
    const { context } = this;
    context.beginPath();
    for (const [x, y] of corners) context.lineTo(this.x(x), this.y(y));
    context.closePath();
    context.globalAlpha = alpha;
    context.fillStyle = color;
    context.fill();
    context.globalAlpha = 1;
  }

  /**
   * Small squares, many; or bars, so wide.
   * @param {ArrayLike<number>} xs @param {ArrayLike<number>} ys
   * @param {{color: string, size?: number, alpha?: number, wide?: number}} look
   */
  dots(xs, ys, { color, size = 1, alpha = 1, wide = size }) {
    const { context } = this;
    context.fillStyle = color;
    context.globalAlpha = alpha;
    const width = Math.max(wide, size);
    for (let k = 0; k < xs.length; k++) {
      context.fillRect(this.x(xs[k]) - width / 2, this.y(ys[k]) - size / 2, width, size);
    }
    context.globalAlpha = 1;
  }

  /** A message in the middle, where there is nothing to draw. @param {string} text */
  message(text) {
    const { context } = this;
    context.font = `12px ${SANS}`;
    context.fillStyle = colors().muted;
    context.textAlign = "center";
    context.textBaseline = "middle";
    const width = this.right - this.left - 20;
    const lines = wrapped(context, text, width);
    const middle = (this.top + this.bottom) / 2 - (lines.length - 1) * 8;
    lines.forEach((line, k) =>
      context.fillText(line, (this.left + this.right) / 2, middle + 16 * k),
    );
  }
}

/** @param {CanvasRenderingContext2D} context @param {string} text @param {number} width */
function wrapped(context, text, width) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = `${lines.at(-1)} ${word}`.trim();
    if (lines.at(-1) && context.measureText(longer).width > width) lines.push(word);
    else lines[lines.length - 1] = longer;
  }
  return lines;
}

/**
 * Symbols in italics with indices, centred: `d_{n+1}`, `X_1`; words in brackets stay upright.
 * @param {CanvasRenderingContext2D} context
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} color @param {string} [after]  in small type behind it
 */
export function mathText(context, text, x, y, color, after = "") {
  const parts = text
    .split(/(_\{[^}]*\}|_\d+|_.)/)
    .filter(Boolean)
    .map((part) => {
      const low = part.startsWith("_");
      const plain = low ? part.replace(/[_{}]/g, "") : part;
      return { plain, low, font: low ? `11px ${MATH}` : `italic 15px ${MATH}` };
    });
  if (after) parts.push({ plain: `  ${after}`, low: false, font: `11px ${SANS}` });
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.fillStyle = color;
  const widths = parts.map(({ plain, font }) => {
    context.font = font;
    return context.measureText(plain).width;
  });
  let at = x - widths.reduce((a, b) => a + b, 0) / 2;
  parts.forEach(({ plain, low, font }, k) => {
    context.font = font;
    context.fillText(plain, at, y + (low ? 3 : 0));
    at += widths[k];
  });
}
