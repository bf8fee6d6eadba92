/**
 * The time of the shown motion, and what the motion does then.
 *
 * @import {Answer} from "./answers.js"
 */
import { nearest } from "./numbers.js";

// Half of a screen's frames are smooth enough, a quarter while answers are computed, and a tenth if
// these have two cores or one: without a graphics card drawing what plays takes a quarter of a core.
const BETWEEN_MS = 25;
const BUSY_MS = navigator.hardwareConcurrency > 2 ? 60 : 150;
const LONGEST_MS = 250; // that the motion goes on between two frames

export class Clock {
  /** @param {() => void} ontick @param {() => boolean} isBusy whether answers are computed */
  constructor(ontick, isBusy) {
    this.ontick = ontick;
    this.isBusy = isBusy;
    this.t = 0;
    this.speed = 8; // units of time per second
    this.playing = false;
    /** @type {Answer | null} */ this.motion = null;
    /** @type {{start: number, end: number, d: number}[]} */ this.phases = [];
    this.last = 0;
    this.run = 0; // number of the present one: a frame of an earlier one may still be due
  }

  /** Take a new motion, at the time of the last one; or none. @param {Answer | null} answer */
  take(answer) {
    this.motion = answer;
    const { arrays } = this;
    if (arrays) {
      arrays.u ??= arrays.x; // contacts of blocks move as these do
      arrays.w ??= arrays.v;
    }
    this.phases = globalSticks(this.arrays);
    this.seek(this.t);
  }

  /** Whose motion it is. @returns {any} */
  get model() {
    return this.motion?.question.request.model;
  }

  /** @returns {any} */
  get arrays() {
    return this.motion?.parts[0]?.arrays ?? null;
  }

  get end() {
    const t = this.arrays?.t;
    return t?.length ? t[t.length - 1] : 0;
  }

  /** @param {boolean} playing */
  play(playing) {
    this.playing = playing;
    this.last = performance.now();
    const run = ++this.run;
    if (playing) requestAnimationFrame((now) => this.#frame(now, run));
  }

  /** @param {number} now @param {number} run */
  #frame(now, run) {
    if (!this.playing || run !== this.run) return;
    const pause = this.isBusy() ? BUSY_MS : BETWEEN_MS;
    setTimeout(() => requestAnimationFrame((next) => this.#frame(next, run)), pause);
    const passed = Math.min(LONGEST_MS, Math.max(0, now - this.last)) / 1000;
    this.last = now;
    this.seek(this.end ? (this.t + this.speed * passed) % this.end : 0);
  }

  /** @param {number} t */
  seek(t) {
    this.t = Math.min(Math.max(t, 0), this.end);
    this.ontick();
  }

  /** Index of the sample nearest to the present time. */
  index() {
    const t = this.arrays?.t;
    return t?.length ? nearest(t, this.t) : -1;
  }

  /**
   * The last global stick phase that has begun, and the d of the next.
   * @returns {{d: number, next: number | null} | null}
   */
  phase() {
    let k = this.phases.length - 1;
    while (k >= 0 && this.phases[k].start > this.t) k--;
    if (k < 0) return null;
    return { d: this.phases[k].d, next: this.phases[k + 1]?.d ?? null };
  }
}

/** Phases in which both of two blocks ride. @param {any} arrays */
function globalSticks(arrays) {
  if (!arrays || arrays.u !== arrays.x || arrays.x.length !== 2 * arrays.t.length) return [];
  const { t, x, mode } = arrays;
  /** @type {{start: number, end: number, d: number}[]} */
  const phases = [];
  let inside = false;
  for (let k = 0; k < t.length; k++) {
    const rides = mode[2 * k] + mode[2 * k + 1] === 0;
    if (rides && !inside) phases.push({ start: t[k], end: t[k], d: x[2 * k + 1] - x[2 * k] });
    if (rides) phases[phases.length - 1].end = t[k];
    inside = rides;
  }
  return phases;
}
