/**
 * The page at work: state to questions, answers to views.
 *
 * @import {Box, Limits, Part, Question, State} from "./types.js"
 * @import {Shipped} from "./shipped.js"
 * @import {View} from "./views/view.js"
 */
import { Answers } from "./answers.js";
import { Clock } from "./clock.js";
import { Connection, Socket, Thread } from "./connection.js";
import { keep } from "./keep.js";
import {
  continuousParameters,
  coordinateOf,
  hasLineMap,
  mapOf,
  parametersOf,
  shapeOf,
  slidersOf,
  valueOf,
  withValue,
} from "./model.js";
import { listed, short, written } from "./numbers.js";
import { PATIENT, QUESTIONS, slotsFor } from "./questions.js";
import { clean, completeAlong, same, Store } from "./state.js";

/** Slots whose answers tell which map a model has, or on what domain. */
const TELLING = new Set(["returns", "locus"]);
const KEPT = 40; // answers that took long, for undo
const SOON_MS = 150; // a head start for the map
const REST_MS = 80; // controls at rest: time for what takes longer

/** @import {Answer, Standing} from "./answers.js" */

export class App {
  /**
   * @param {Limits} limits
   * @param {State} state
   * @param {Shipped} shipped
   * @param {(open: boolean, steps?: {done: number, of: number}) => void} onconnection
   */
  constructor(limits, state, shipped, onconnection) {
    this.limits = limits;
    this.shipped = shipped;
    /** Whether there is no server: the page shows what was shipped with it. */
    this.alone = document.documentElement.hasAttribute("data-alone");
    this.store = new Store(state);
    /** @type {View[]} */ this.views = [];
    /** Those that can be shown large. @type {View[]} */ this.presentable = [];
    this.known = new Answers();
    /** Of each slot what was asked last, unless it was stopped. @type {Map<string, string>} */
    this.asked = new Map();
    /** @type {Map<string, Answer>} */ this.kept = new Map();
    /** @type {Record<string, number>} */ this.widths = {};
    /** @type {Map<string, (() => void)[]>} */ this.waiters = new Map();
    this.clock = new Clock(
      () => this.views.forEach((view) => view.tick()),
      () => this.connection.running.size > 0,
    );
    /** @type {(t: number) => void} */ this.showTime = () => {};
    /** @type {(fields: string[], message: string) => void} */ this.showError = () => {};
    /** @type {(message: string, lasts?: boolean) => void} */ this.announce = () => {};
    /** What is shown may have other names. */
    this.arrange = () => {};
    this.restTimer = 0;
    /** Of the system whose answers are known. */ this.shape = "";
    const url = new URL("ws", location.href);
    url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    url.hash = "";
    this.connection = new Connection(
      this.alone ? new Thread() : new Socket(url.href),
      (open, steps) => {
        onconnection(open, steps);
        this.judge();
      },
    );
    this.store.subscribe(() => this.changed());
  }

  get state() {
    return this.store.state;
  }

  /** What is shown. @type {Map<string, Answer>} */
  get answers() {
    return this.known.shown;
  }

  /** Views presented, if any: those of the state that the model has. */
  get large() {
    const known = this.presentable.filter((view) => view.isFor(this.state)).map(({ id }) => id);
    return this.state.large.filter((id) => known.includes(id));
  }

  /** Present value of the diagram's parameter. */
  get parameter() {
    return Number(valueOf(this.limits, this.state.model, this.state.diagram.parameter));
  }

  /** Of a parameter, or of `d`. @param {string} name */
  symbol(name) {
    if (name === "d") return coordinateOf(this.state);
    const known = continuousParameters(this.limits, this.state.model, { [name]: true });
    return known.find((one) => one.name === name)?.symbol ?? name;
  }

  /** A parameter, or `d`, as it is named in texts. @param {string} name */
  written(name) {
    return written(this.symbol(name));
  }

  // --- changes that several controls make ------------------------------------------------------

  /** Start the motion from a point of the map. @param {number} d */
  startAt(d) {
    const inside = this.#inside(d);
    if (clean(inside) !== clean(d))
      this.announce(`${this.written("d")} = ${short(d)} lies outside the domain: its end ${short(inside)} is taken`);
    this.store.update({ d: inside }, "d");
  }

  /** The nearest point of the map's domain. @param {number} d */
  #inside(d) {
    const [low, high] = (hasLineMap(this.state) && this.domain()) || [-Infinity, Infinity];
    return Math.min(high, Math.max(low, clean(d))); // in this order: an end rounded may lie outside
  }

  /**
   * Set the diagram's parameter, perhaps the start too.
   * @param {number} value
   * @param {number} [d]
   */
  goTo(value, d) {
    const { parameter } = this.state.diagram;
    const model = withValue(this.limits, this.state.model, parameter, clean(value));
    const start = d === undefined ? {} : { d: this.#inside(d) };
    this.store.update({ model, ...start }, `value:${parameter}`);
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
    const { parameter, max_period } = this.state.diagram;
    const diagram = completeAlong(this.limits, model, { parameter, max_period });
    const anew = { map: null, section: null, sliders: slidersOf(this.limits, model) };
    this.store.update({ model, diagram, windows: {}, ...anew }, "model");
  }

  /** @param {string} panel @param {Box | null} box */
  zoom(panel, box) {
    const { diagram, windows } = this.state;
    if (panel !== "diagram") {
      const bounded = panel === "map" || panel === "power" ? this.#bounded(box) : box;
      if (!bounded && !windows[panel]) return;
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
    return this.answers.get("map")?.parts.find(({ data }) => data.domain)?.data.domain;
  }

  // --- questions -------------------------------------------------------------------------------

  changed() {
    this.#forgetOthers();
    this.askAll(); // first: the server works while the views are drawn
    const { large } = this;
    for (const view of this.views) {
      const shown = view.isFor(this.state) && (!large.length || large.includes(view.id));
      view.panel.section.hidden = !shown;
      if (!shown) continue;
      const { range, full, view: vertical } = this.state.diagram;
      const zoomed =
        view.id === "diagram"
          ? Boolean(vertical) || !same(range, full)
          : Boolean(this.state.windows[view.zoomed]);
      view.panel.reset.hidden = !zoomed;
      view.show();
    }
    this.arrange();
    this.judge();
  }

  /** Answers of another system are no older values of this one. */
  #forgetOthers() {
    const shape = shapeOf(this.state);
    if (shape !== this.shape) {
      for (const slot of [...this.connection.running.keys()]) this.connection.forget(slot);
      this.asked.clear();
      this.known.clear();
      this.clock.take(null);
    }
    this.shape = shape;
  }

  /** Ask what is new: the map first, what is quick after it, the rest when the controls rest. */
  askAll() {
    const slots = slotsFor(this.state);
    for (const slot of this.connection.running.keys()) if (!slots.includes(slot)) this.cancel(slot);
    if (!this.state.map) TELLING.forEach((slot) => this.asked.delete(slot)); // as told, but forgotten
    if (slots.includes("map") && !this.alone) this.ask("map"); // a thread gives way to nothing quick
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
    if (kept) {
      this.connection.forget(slot);
      return this.#offer(slot, text, kept);
    }
    const base = { question, before: [], done: true, shipped: true, progress: 1 };
    const shipped = this.shipped.find(question);
    shipped
      ?.then((parts) => this.#offer(slot, text, { ...base, parts }))
      .catch(() => this.#unread(slot, question, text));
    if (this.alone && shipped) return this.connection.forget(slot); // there is no better one
    this.connection.ask(slot, question, (/** @type {Part} */ part) =>
      this.receive(slot, question, part),
    );
  }

  /**
   * Show a whole answer that was given before, or shipped, if it is still asked for.
   * @param {string} slot @param {string} text @param {Answer} answer
   */
  #offer(slot, text, answer) {
    if (this.asked.get(slot) !== text || !this.known.offer(slot, answer)) return;
    if (slot === "motion") this.#move();
    if (TELLING.has(slot)) answer.parts.forEach((part) => this.#mapTold(part));
    this.#tell(slot);
  }

  /** What was shipped does not load: nothing else comes, if there is no server. @param {string} slot @param {Question} question @param {string} text */
  #unread(slot, question, text) {
    if (!this.alone || this.asked.get(slot) !== text) return;
    this.asked.delete(slot);
    const error = { message: "its file does not load" };
    this.receive(slot, question, { id: 0, part: 0, view: "", last: true, progress: 0, data: {}, arrays: {}, error });
  }

  /** Stop; the same question may be asked again at once. @param {string} slot */
  cancel(slot) {
    const runs = this.connection.running.has(slot);
    this.connection.cancel(slot);
    if (runs) this.asked.delete(slot); // only now: what follows the map asks all that is not asked
  }

  /** @param {string} slot @param {Question} question @param {Part} part */
  receive(slot, question, part) {
    const answer = this.known.receive(slot, question, part, this.question(slot));
    if (slot === "motion") this.#move();
    if (TELLING.has(slot) && same(question, this.question(slot))) this.#mapTold(part);
    if (answer.done && PATIENT.has(slot)) this.#keep(JSON.stringify(question), answer);
    if (part.data.part_name === "progress" && this.answers.has(slot)) this.judge();
    else this.#tell(slot, part);
    if (answer.done || part.error || part.cancelled) this.#idle(slot);
  }

  /** @param {string} slot @param {Part} [part]  of its answer, if only this is new */
  #tell(slot, part) {
    for (const view of this.views) if (view.shows(slot, part)) view.refresh();
    this.arrange();
    this.judge();
  }

  /** @param {string} text @param {Answer} answer */
  #keep(text, answer) {
    this.kept.delete(text);
    this.kept.set(text, answer);
    if (this.kept.size > KEPT)
      this.kept.delete(/** @type {string} */ (this.kept.keys().next().value));
  }

  /** @param {string} slot @returns {Standing} */
  standing(slot) {
    const { running, lost } = this.connection;
    const link = { running: running.has(slot), open: !lost };
    return this.known.standing(slot, this.question(slot), link);
  }

  /** Show every view's state, and what is wrong with the values in one place. */
  judge() {
    const standings = new Map(slotsFor(this.state).map((slot) => [slot, this.standing(slot)]));
    for (const { panel, slots } of this.views) {
      panel.stand(standings.get(slots[0]));
      panel.list(slots.flatMap((slot) => standings.get(slot)?.unresolved ?? []));
    }
    const [slot, wrong] = [...standings].find(([, { error }]) => error?.field) ?? [];
    const field = wrong?.error?.field ?? null;
    const message = wrong?.error?.message ?? "";
    const changed = field === "model" ? this.#changed() : [];
    if (changed.length) {
      const values = changed.map((name) => `${name} = ${valueOf(this.limits, this.state.model, name)}`);
      return this.showError(changed, `${listed(values)}: ${message}`);
    }
    // The model of a diagram has the start of its range: see its question.
    const begins = slot === "diagram" && field === `model.${this.state.diagram.parameter}`;
    this.showError(begins ? ["range[0]"] : [field ?? ""], message);
  }

  /** Names of the numbers that differ from those of the last model that was answered. */
  #changed() {
    const { limits, state } = this;
    const last = this.answers.get("law")?.question.request.model ?? state.model;
    const known = [state.model, last].flatMap((model) => Object.values(parametersOf(limits, model)).flat(2));
    const value = (/** @type {any} */ model, /** @type {string} */ name) => valueOf(limits, model, name);
    const differ = known.filter(({ name }) => !same(value(state.model, name), value(last, name)));
    return [...new Set(differ.map(({ name }) => name))];
  }

  /** Which map the model has is part of the state, so that all else follows from the state. @param {Part} part */
  #mapTold({ data }) {
    if (!TELLING.has(data?.part_name)) return;
    const { kind, why, coordinates, domain } = { ...mapOf(this.state), ...data };
    const map = { kind, why, coordinates, domain };
    if (!same(map, this.state.map)) this.store.learn({ map });
  }

  #move() {
    const answer = this.answers.get("motion");
    if (answer && answer !== this.clock.motion) this.clock.take(answer);
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
    if (width === this.widths[id]) return; // a sentence has another line: what was stopped stays so
    this.widths[id] = width;
    clearTimeout(this.sizeTimer);
    this.sizeTimer = setTimeout(() => this.askAll(), REST_MS);
  }

  /**
   * Save what a panel shows as a file, or copy the calls that make it.
   * @param {View} view @param {string} picture @param {string} format
   */
  async save({ slots, extra, frame, panel }, picture, format) {
    const request = { ...this.question(slots[0]).request, ...extra };
    const title = panel.title.textContent ?? "";
    try {
      await keep({ view: picture, request, format, frame }, title, this.announce);
    } catch (error) {
      this.announce(`Not saved: ${/** @type {Error} */ (error).message}`);
    }
  }
}
