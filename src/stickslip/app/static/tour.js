/**
 * A walk through the two bifurcations of the paper: each step sets the sliders, its text moves them.
 *
 * @import {App} from "./app.js"
 * @import {Preset} from "./types.js"
 */
import { element, leave } from "./dom.js";
import { completeState } from "./state.js";

/** A step: the preset it begins with, and a text in which pairs move a slider. */
export const STEPS = /** @type {const} */ ([
  {
    preset: "coulomb",
    title: "Two motions at once",
    text: [
      "Two blocks ride on a belt until springs tear them off. Each time both stick, their distance d is noted; the event map leads from one d to the next. Where it meets the diagonal, the motion repeats. Under Coulomb friction two motions attract: S1, and S4, which takes four sticks to repeat.",
    ],
  },
  {
    preset: "fig06",
    title: "An orbit nears a jump",
    text: [
      "The map jumps where a block just touches the belt's speed: it grazes. As the belt gets faster, from ",
      ["V", 0.0366],
      " to ",
      ["V", 0.0369],
      ", a point of S4 runs towards the jump at d = 0.2794, where block 2 grazes.",
    ],
  },
  {
    preset: "fig08",
    title: "The first bifurcation",
    text: [
      "At V = 0.036976 they meet: a border collision, BC in the diagram. S4 is stable up to there and gone beyond. Compare ",
      ["V", 0.0369],
      " with ",
      ["V", 0.037],
      ": motions now hop around the place where S4 was, and repeat after 83 sticks. S1 does not notice.",
    ],
  },
  {
    preset: "law9",
    title: "A cusp in place of a jump",
    text: [
      "Now friction falls smoothly with speed, law (9). Where block 2 grazes, at d = 0.3815, the map no longer jumps: it has a cusp, a corner at which the slope goes from 5.95 to −2.19. S1, right of it, attracts: its multiplier is −0.94, near −1.",
    ],
  },
  {
    preset: "fig14",
    title: "The second bifurcation",
    text: [
      "With stiffer coupling, from ",
      ["alpha", 1.208],
      " to ",
      ["alpha", 1.211],
      ", period-2 orbits are born at the cusp (BC, α = 1.20912), S1 loses its stability (PD, 1.20986), and motions wander in two bands: chaos. At CR, α = 1.2153, the chaos meets an unstable orbit and ends.",
    ],
  },
]);

export class Tour {
  /** @param {App} app @param {Preset[]} presets @param {HTMLElement} host */
  constructor(app, presets, host) {
    this.app = app;
    this.presets = presets;
    this.at = 0;
    /** What had the focus before. @type {Element | null} */ this.from = null;
    const named = { class: "tour", "aria-labelledby": "tour-title", "aria-live": "polite" };
    this.section = element("section", { ...named, hidden: true });
    host.prepend(this.section);
  }

  get shown() {
    return !this.section.hidden;
  }

  /** Hide, or go on where it was left. */
  toggle() {
    if (this.shown) return this.#hide();
    this.from = document.activeElement;
    this.#show(this.at);
  }

  /** On or back, as far as there are steps. @param {number} steps */
  step(steps) {
    const to = this.at + steps;
    if (STEPS[to]) this.#show(to);
  }

  #hide() {
    leave(this.section, this.from, () => (this.section.hidden = true));
  }

  #end() {
    this.#hide();
    this.at = 0;
  }

  /** @param {number} at */
  #show(at) {
    this.at = at;
    const { preset, title, text } = STEPS[at];
    const state = this.presets.find(({ name }) => name === preset)?.state ?? {};
    const { large } = this.app.state;
    this.app.store.update({ ...completeState(this.app.limits, state), large }, "tour");
    const last = at === STEPS.length - 1;
    const next = last
      ? [button("Done", () => this.#end())]
      : [button("Next", () => this.step(1)), button("End", () => this.#end())];
    const back = button("Back", () => this.step(-1), at === 0);
    const pieces = text.map((piece) => (typeof piece === "string" ? piece : this.#move(piece)));
    this.section.replaceChildren(
      element("h2", { id: "tour-title" }, `${at + 1} of ${STEPS.length}: ${title}`),
      element("p", {}, ...pieces),
      element("div", { class: "row buttons" }, back, ...next),
    );
    this.section.hidden = false;
    document.querySelector(".panel-map")?.scrollIntoView();
    this.section.scrollIntoView({ block: "nearest" });
    next[0].focus();
  }

  /** @param {readonly [string, number]} to */
  #move([name, value]) {
    const symbol = name === "alpha" ? "α" : name;
    return button(`${symbol} = ${value}`, () => this.app.setParameter(name, value), false, "move");
  }
}

/** @param {string} text @param {() => void} onclick @param {boolean} [disabled] @param {string} [kind] */
const button = (text, onclick, disabled = false, kind = "plain") =>
  element("button", { type: "button", class: kind, onclick, disabled }, text);
