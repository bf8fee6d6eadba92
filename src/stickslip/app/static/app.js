/**
 * The page at work: state to questions, answers to views.
 *
 * @import {Box, Limits, Part, Preset, Question, State} from "./types.js"
 * @import {View} from "./views/view.js"
 * @import {Panel} from "./panel.js"
 */
import { Clock } from "./clock.js";
import { Connection } from "./connection.js";
import { keep } from "./keep.js";
import {
  blockCount,
  continuousParameters,
  hasLineMap,
  indexed,
  valueOf,
  withValue,
} from "./model.js";
import { PATIENT, QUESTIONS, slotsFor } from "./questions.js";
import { clean, completeAlong, Store } from "./state.js";

const EMPTY = new Set(["progress", "end"]); // parts that only tell how far an answer is
const KEPT = 40; // answers that took long, for undo
const SOON_MS = 150; // a head start for the map
const REST_MS = 80; // controls at rest: time for what takes longer

/**
 * @typedef {object} Answer  what is known of the newest answer of a slot
 * @property {Question} question
 * @property {Part[]} parts
 * @property {Part[]} before  the parts of the answer that it replaces
 * @property {{message: string, field?: string | null}} [error]
 * @property {boolean} [cancelled]
 * @property {boolean} done
 */

export class App {
  /**
   * @param {Limits} limits
   * @param {State} state
   * @param {(open: boolean, warm: boolean) => void} onconnection
   */
  constructor(limits, state, onconnection) {
    this.limits = limits;
    this.store = new Store(state);
    /** @type {View[]} */ this.views = [];
    /** @type {Map<string, Answer>} */ this.answers = new Map();
    /** Of each slot what was asked last, unless it was stopped. @type {Map<string, string>} */
    this.asked = new Map();
    /** @type {Map<string, Answer>} */ this.kept = new Map();
    /** @type {Record<string, number>} */ this.widths = {};
    /** @type {Map<string, (() => void)[]>} */ this.waiters = new Map();
    this.clock = new Clock(() => this.views.forEach((view) => view.tick()));
    /** @type {(t: number) => void} */ this.showTime = () => {};
    /** @type {(field: string | null, message: string) => void} */ this.showError = () => {};
    /** @type {(message: string) => void} */ this.announce = () => {};
    this.restTimer = 0;
    const url = new URL("ws", location.href);
    url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    url.hash = "";
    this.connection = new Connection(url.href, onconnection);
    this.store.subscribe(() => this.changed());
  }

  get state() {
    return this.store.state;
  }

  /** @param {State} state */
  blocks(state) {
    return blockCount(state.model);
  }

  /** Present value of the diagram's parameter. */
  get parameter() {
    return Number(valueOf(this.limits, this.state.model, this.state.diagram.parameter));
  }

  /** @param {string} name */
  symbol(name) {
    const known = continuousParameters(this.limits, this.state.model);
    return indexed(known.find((one) => one.name === name)?.symbol ?? name);
  }

  // --- changes that several controls make ------------------------------------------------------

  /** Start the motion from a point of the map. @param {number} d */
  startAt(d) {
    const domain = hasLineMap(this.state.model) ? this.domain() : undefined;
    const inside = domain ? Math.min(domain[1], Math.max(domain[0], d)) : d;
    this.store.update({ d: clean(inside) }, "d");
  }

  /**
   * Set the diagram's parameter, perhaps the start too.
   * @param {number} value
   * @param {number} [d]
   */
  goTo(value, d) {
    const { parameter } = this.state.diagram;
    const model = withValue(this.limits, this.state.model, parameter, clean(value));
    this.store.update(d === undefined ? { model } : { model, d: clean(d) }, `value:${parameter}`);
  }

  /** @param {string} name @param {any} value */
  setParameter(name, value) {
    const model = withValue(this.limits, this.state.model, name, value);
    this.store.update({ model }, `value:${name}`);
  }

  /**
   * Another kind or law: ranges and zooms of the old model mean nothing there.
   * @param {any} model
   */
  setModel(model) {
    const diagram = completeAlong(this.limits, model, { parameter: this.state.diagram.parameter });
    this.store.update({ model, diagram, windows: {} }, "model");
  }

  /** @param {string} panel @param {Box | null} box */
  zoom(panel, box) {
    const { diagram, windows } = this.state;
    if (panel !== "diagram") {
      const bounded = panel === "map" || panel === "power" ? this.#bounded(box) : box;
      this.store.update(
        { windows: { ...windows, [panel]: bounded && /** @type {Box} */ (bounded.map(clean)) } },
        `zoom:${panel}`,
      );
    } else if (box) {
      const [x0, x1, y0, y1] = box.map(clean);
      this.store.update(
        { diagram: { ...diagram, range: [x0, x1], view: [y0, y1] } },
        "zoom:diagram",
      );
    } else {
      this.store.update(
        { diagram: { ...diagram, range: diagram.full, view: null } },
        "zoom:diagram",
      );
    }
  }

  /** The map's window ends where its domain does. @param {Box | null} box */
  #bounded(box) {
    const domain = this.domain();
    if (!box || !domain) return box;
    const [low, high] = [Math.max(box[0], domain[0]), Math.min(box[1], domain[1])];
    const whole = low <= domain[0] && high >= domain[1];
    return whole || !(high > low) ? null : /** @type {Box} */ ([low, high, box[2], box[3]]);
  }

  /** Of the event map, once it is known. @returns {[number, number] | undefined} */
  domain() {
    return this.answers.get("map")?.parts[0]?.data.domain;
  }

  // --- questions -------------------------------------------------------------------------------

  changed() {
    for (const view of this.views) {
      const shown = view.isFor(this.state);
      view.panel.section.hidden = !shown;
      if (!shown) continue;
      const zoomed =
        view.id === "diagram"
          ? this.state.diagram.range !== this.state.diagram.full
          : Boolean(this.state.windows[view.id]);
      if (view.panel.reset) view.panel.reset.hidden = !zoomed;
      view.update();
    }
    this.askAll();
  }

  /** Ask what is new: the map first, what is quick after it, the rest when the controls rest. */
  askAll() {
    const slots = slotsFor(this.state);
    if (slots.includes("map")) this.ask("map");
    clearTimeout(this.soonTimer);
    if (this.connection.running.has("map")) {
      this.soonTimer = setTimeout(() => this.askQuick(), SOON_MS);
    } else this.askQuick();
    clearTimeout(this.restTimer);
    this.restTimer = setTimeout(() => {
      for (const slot of slots) if (PATIENT.has(slot)) this.ask(slot);
    }, REST_MS);
  }

  /** What the map's answer goes before, if it is not long. */
  askQuick() {
    clearTimeout(this.soonTimer);
    for (const slot of this.quickSlots) this.ask(slot);
  }

  /** @param {string} slot */
  ask(slot) {
    const question = this.question(slot);
    const text = JSON.stringify(question);
    if (this.asked.get(slot) === text) return;
    this.asked.set(slot, text);
    const kept = this.kept.get(text);
    if (kept) return this.#recall(slot, kept);
    this.#own(slot)?.panel.busy(0);
    this.connection.ask(slot, question, (part) => this.receive(slot, question, part));
    if (!this.answers.has(slot)) this.#tell(slot);
  }

  /**
   * Show an answer that took long and was given before.
   * @param {string} slot
   * @param {Answer} answer
   */
  #recall(slot, answer) {
    this.connection.forget(slot);
    this.answers.set(slot, answer);
    this.#own(slot)?.panel.busy(null);
    this.#tell(slot);
  }

  /** Stop; the same question may be asked again at once. @param {string} slot */
  cancel(slot) {
    if (this.connection.running.has(slot)) this.asked.delete(slot);
    this.connection.cancel(slot);
  }

  /** @param {string} slot @param {Question} question @param {Part} part */
  receive(slot, question, part) {
    const known = this.answers.get(slot);
    const answer =
      known?.question === question
        ? known
        : {
            question,
            parts: [],
            before: known?.done ? known.parts : (known?.before ?? []),
            done: false,
          };
    this.answers.set(slot, answer);
    answer.error = part.error;
    answer.cancelled = part.cancelled;
    answer.done = Boolean(part.last && !part.error && !part.cancelled);
    if (part.error) answer.parts = [];
    else if (!part.cancelled && !EMPTY.has(part.data.part_name)) answer.parts.push(part);
    this.#progress(slot, question, part);
    if (slot === "motion" && answer.parts[0] === part) this.#move(answer);
    if (answer.done && PATIENT.has(slot)) this.#keep(JSON.stringify(question), answer);
    this.#tell(slot);
    if (answer.done || part.error || part.cancelled) this.#idle(slot);
  }

  /** @param {string} slot */
  #tell(slot) {
    for (const view of this.views) if (view.slots.includes(slot)) view.refresh();
  }

  /** @param {string} text @param {Answer} answer */
  #keep(text, answer) {
    this.kept.delete(text);
    this.kept.set(text, answer);
    if (this.kept.size > KEPT)
      this.kept.delete(/** @type {string} */ (this.kept.keys().next().value));
  }

  /** @param {string} slot @param {Question} question @param {Part} part */
  #progress(slot, question, part) {
    const ended = part.last || part.error || part.cancelled;
    const panel = this.#own(slot)?.panel;
    panel?.busy(ended && !this.connection.running.has(slot) ? null : (part.progress ?? 0));
    if (part.error) {
      panel?.say(part.error.message, true);
      const current = JSON.stringify(question) === JSON.stringify(this.question(slot));
      if (current) this.showError(part.error.field ?? null, part.error.message);
      return;
    }
    if (panel?.note.classList.contains("error")) panel.say("");
    if (slot === "map") this.showError(null, "");
  }

  /**
   * A motion from elsewhere starts anew; after a change of the model it goes on.
   * @param {Answer} answer
   */
  #move(answer) {
    const same = JSON.stringify(this.start) === JSON.stringify(answer.question.request.start);
    const { t } = this.clock;
    this.start = answer.question.request.start;
    this.clock.take(answer);
    if (same) this.clock.seek(t);
  }

  /** @param {string} slot */
  #own(slot) {
    return this.views.find((view) => view.slots[0] === slot);
  }

  /** Resolves when nothing of a slot is under way. @param {string} slot @returns {Promise<void>} */
  whenIdle(slot) {
    if (!this.connection.running.has(slot)) return Promise.resolve();
    return new Promise((resolve) =>
      this.waiters.set(slot, [...(this.waiters.get(slot) ?? []), resolve]),
    );
  }

  /** @param {string} slot */
  #idle(slot) {
    if (this.connection.running.has(slot)) return;
    if (slot === "map") this.askQuick();
    for (const resolve of this.waiters.get(slot) ?? []) resolve();
    this.waiters.delete(slot);
  }

  get quickSlots() {
    return slotsFor(this.state).filter((slot) => !PATIENT.has(slot));
  }

  /** What a slot asks in the present state. @param {string} slot */
  question(slot) {
    return QUESTIONS[slot](this.state, this.widths, this.limits);
  }

  /**
   * Whether these slots, by default all, show answers to the present state.
   * @param {string[]} [slots]
   */
  settled(slots = slotsFor(this.state)) {
    return slots.every(
      (slot) =>
        this.asked.get(slot) === JSON.stringify(this.question(slot)) &&
        !this.connection.running.has(slot),
    );
  }

  /**
   * A plot has another size: what it shows wants another resolution.
   * @param {string} id
   * @param {number} width
   */
  sized(id, width) {
    this.widths[id] = width;
    clearTimeout(this.sizeTimer);
    this.sizeTimer = setTimeout(() => this.askAll(), REST_MS);
  }

  /**
   * Save what a panel shows as a file, or copy the calls that make it.
   * @param {string} picture @param {string} slot @param {Record<string, any>} extra
   * @param {string} format @param {Panel} panel
   */
  async save(picture, slot, extra, format, panel) {
    const question = this.question(slot);
    panel.section.setAttribute("data-saving", format);
    try {
      await keep(
        { view: picture, request: { ...question.request, ...extra }, format },
        this.announce,
      );
    } catch (error) {
      this.announce(`Not saved: ${/** @type {Error} */ (error).message}`);
    }
    panel.section.removeAttribute("data-saving");
  }
}
