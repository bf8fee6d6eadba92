/**
 * Moves along the diagram's parameter, a step when the map before is drawn.
 *
 * @import {App} from "./app.js"
 */
const STEPS = 200; // over the range
const PAUSE_MS = 40;

export class Player {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.playing = this.going = false;
    this.run = 0; // number of the present one: a step of an earlier one may still be due
    /** @type {(playing: boolean) => void} */ this.onchange = () => {};
    this.along = app.state;
    app.store.subscribe((state) => {
      const { model, diagram } = this.along;
      const other = state.model !== model || state.diagram.parameter !== diagram.parameter;
      if (this.playing && other && !this.going) this.stop(); // somebody else goes elsewhere
      this.along = state;
    });
  }

  /** @param {number} value */
  #go(value) {
    this.going = true;
    this.app.goTo(value);
    this.going = false;
  }

  /** @param {number} steps @returns {boolean} whether the range goes on from there */
  step(steps) {
    const { app } = this;
    const [low, high] = app.state.diagram.range;
    const value = app.parameter + (steps * (high - low)) / STEPS;
    this.#go(Math.min(high, Math.max(low, value)));
    return value < high;
  }

  toggle() {
    if (this.playing) return this.stop();
    const [low, high] = this.app.state.diagram.range;
    const { parameter } = this.app;
    const outside = parameter < low || parameter >= high - 1e-9 * (high - low);
    if (outside) this.#go(low);
    this.playing = true;
    this.onchange(true);
    this.#play(++this.run);
  }

  stop() {
    this.playing = false;
    this.onchange(false);
  }

  /** @param {number} run */
  async #play(run) {
    const goesOn = () => this.playing && run === this.run;
    while (goesOn()) {
      await this.app.whenIdle("map");
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
      if (goesOn() && !this.step(1)) this.stop();
    }
  }
}
