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
    this.playing = false;
    /** @type {(playing: boolean) => void} */ this.onchange = () => {};
  }

  /** @param {number} steps @returns {boolean} whether the range goes on from there */
  step(steps) {
    const { app } = this;
    const [low, high] = app.state.diagram.range;
    const value = app.parameter + (steps * (high - low)) / STEPS;
    app.goTo(Math.min(high, Math.max(low, value)));
    return value < high;
  }

  toggle() {
    if (this.playing) return this.stop();
    const [low, high] = this.app.state.diagram.range;
    const { parameter } = this.app;
    const outside = parameter < low || parameter >= high - 1e-9 * (high - low);
    if (outside) this.app.goTo(low);
    this.playing = true;
    this.onchange(true);
    this.#run();
  }

  stop() {
    this.playing = false;
    this.onchange(false);
  }

  async #run() {
    while (this.playing) {
      await this.app.whenIdle("map");
      await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
      if (this.playing && !this.step(1)) this.stop();
    }
  }
}
