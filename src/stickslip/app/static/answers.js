/**
 * One rule for all answers: which of them is shown, and in what state it is.
 *
 * An answer stays until a newer one can take its place; what is shown is current, being computed,
 * an example that came with the package, or of other values than those asked for.
 *
 * @import {Part, Question} from "./types.js"
 */
import { alike } from "./shipped.js";

const EMPTY = new Set(["progress", "end"]); // parts that only tell how far an answer is

/**
 * When a picture is whole enough to take the place of an older one.
 * @type {Record<string, (parts: Part[]) => boolean>}
 */
const ENOUGH = {
  basins: (parts) => parts.some(({ arrays }) => arrays.label),
  diagram: (parts) => parts.some(({ progress }) => progress >= 0.2),
};

/**
 * @typedef {object} Answer
 * @property {Question} question
 * @property {Part[]} parts
 * @property {Part[]} before  the parts of the answer that it replaces
 * @property {{message: string, field?: string | null}} [error]
 * @property {boolean} [cancelled]
 * @property {boolean} [missing]  whether nothing here computes it
 * @property {boolean} [shipped]
 * @property {number} [compiling]  for how many seconds the server compiles kernels for it
 * @property {boolean} [waiting]  whether the server computes other views first
 * @property {boolean} done
 * @property {number} progress
 *
 * @typedef {object} Standing  the state of what a view shows
 * @property {"empty" | "current" | "computing" | "example" | "stale" | "failed"} kind
 * @property {string} reason  in words, empty where it is current
 * @property {number | null} progress
 * @property {Answer["error"]} [error]
 * @property {string[]} unresolved  what a whole answer to the present values leaves undecided
 */

export class Answers {
  constructor() {
    /** @type {Map<string, Answer>} */ this.shown = new Map();
    /** @type {Map<string, Answer>} */ this.newest = new Map();
  }

  clear() {
    this.shown.clear();
    this.newest.clear();
  }

  /**
   * Take a part; tell its answer.
   * @param {string} slot @param {Question} question @param {Part} part
   * @param {Question} present  what the page asks now
   */
  receive(slot, question, part, present) {
    let answer = this.newest.get(slot);
    const shown = this.shown.get(slot);
    if (answer?.question !== question) {
      const before = (shown?.done ? shown.parts : shown?.before) ?? [];
      answer = { question, parts: [], before, done: false, progress: 0 };
      this.newest.set(slot, answer);
    }
    answer.error = part.error;
    answer.compiling = part.data.compiling;
    answer.waiting = part.data.waiting;
    answer.missing = part.data.missing;
    answer.cancelled = part.cancelled;
    answer.done = Boolean(part.last && !part.error && !part.cancelled);
    // Parts of an answer are worked on side by side: the later may be told of first.
    answer.progress = Math.max(part.progress ?? 0, answer.progress);
    if (!part.error && !part.cancelled && !EMPTY.has(part.data.part_name)) answer.parts.push(part);
    const late = shown && alike(shown.question, present) && !alike(question, present);
    if (!late && this.#takesOver(slot, answer, shown)) this.shown.set(slot, answer);
    return answer;
  }

  /** @param {string} slot @param {Answer} answer @param {Answer} [shown] */
  #takesOver(slot, answer, shown) {
    if (answer.error || !answer.parts.length) return false;
    if (!shown || answer.done) return true;
    if (shown.done && alike(shown.question, answer.question)) return false;
    return (ENOUGH[slot] ?? (() => true))(answer.parts);
  }

  /** Show a whole answer, unless a live one is there. @param {string} slot @param {Answer} answer */
  offer(slot, answer) {
    const shown = this.shown.get(slot);
    if (shown?.done && !shown.shipped && alike(shown.question, answer.question)) return false;
    this.shown.set(slot, answer);
    if (this.newest.get(slot)?.error) this.newest.delete(slot); // it failed once
    return true;
  }

  /**
   * @param {string} slot
   * @param {Question} present  what the page asks now
   * @param {{running: boolean, open: boolean}} link
   * @returns {Standing}
   */
  standing(slot, present, { running, open }) {
    const [shown, newest] = [this.shown.get(slot), this.newest.get(slot)];
    const asked = newest && alike(newest.question, present) ? newest : undefined;
    const fits = shown && alike(shown.question, present);
    const progress = running && open ? (asked?.progress ?? 0) : null;
    const texts = (fits && shown.done && shown.parts.flatMap(({ data }) => data.unresolved ?? [])) || [];
    const unresolved = [...new Set(/** @type {string[]} */ (texts))]; // parts tell the same of one table
    const as = (/** @type {Standing["kind"]} */ kind, reason = "", error = asked?.error) => ({
      kind,
      reason,
      progress,
      error,
      unresolved,
    });
    if (asked?.error)
      return as("failed", asked.error.field ? "not with these values" : asked.error.message);
    if (fits && shown.shipped)
      return as(
        "example",
        running && open ? "shipped; yours is being computed" : "shipped with the package",
      );
    if (fits && shown.done) return as("current");
    const why = reason({ running, open, missing: Boolean(asked?.missing), stopped: Boolean(asked?.cancelled) });
    const later = asked?.waiting
      ? "after other views"
      : asked?.compiling && `compiling kernels, the first time only: ${asked.compiling} s`;
    if (!why && running && later) return as(shown ? "stale" : "empty", later);
    if (!shown) return as("empty", why);
    if (fits && !why) return as("computing", `${Math.round(100 * (progress ?? 0))} %`);
    return as("stale", why || "computing");
  }
}

/** Why an answer to the present values is not on its way; empty if it is. */
function reason(/** @type {Record<string, boolean>} */ { running, open, missing, stopped }) {
  if (missing && !running) return "not computed on this page: stickslip explore does";
  if (!open) return "the server does not answer";
  return stopped && !running ? "stopped" : "";
}
