/**
 * What all views share: a panel, the answers they use, zoom kept in the state.
 *
 * @import {App} from "../app.js"
 * @import {Answer} from "../answers.js"
 * @import {Options} from "../plot.js"
 * @import {Part, State} from "../types.js"
 */
import { element } from "../dom.js";
import { Panel } from "../panel.js";
import { Plot } from "../plot.js";

export const OUTSIDE = " All values lie outside what is shown.";

/** What is seen of a plot's axes, if that is not all. @param {import("../types.js").Box | null | undefined} box */
export const framed = (box) => (box ? { xlim: box.slice(0, 2), ylim: box.slice(2) } : {});

export class View {
  /**
   * @param {App} app
   * @param {{id: string, title: string, help: string, slots: string[], export: string}} of
   *   `slots`: the questions whose answers it shows, its own first; `export`: the server's picture
   */
  constructor(app, { id, title, help, slots, export: picture }) {
    this.app = app;
    this.id = id;
    this.slots = slots;
    this.zoomed = id; // the panel whose zoom it shows
    /** @type {Plot[]} */ this.plots = [];
    const exports = (!app.alone && app.limits.exports[picture]) || [];
    this.panel = new Panel(
      { id, title, help, exports },
      {
        onexport: (format) => app.save(this, picture, format),
        oncancel: () => app.cancel(slots[0]),
        onreset: () => this.resetZoom(),
      },
    );
  }

  /** @param {Options} options */
  addPlot(options) {
    const host = element("div", {});
    this.panel.body.append(host);
    const plot = new Plot(host, options);
    this.plots.push(plot);
    plot.onresize = () => this.app.sized(this.id, plot.width ?? 0);
    return plot;
  }

  /** Zoom of a plot is part of the state, under the panel's name. @param {Plot} plot */
  zoomable(plot) {
    plot.onzoom = (box) => this.app.zoom(this.id, box);
    plot.onreset = () => this.resetZoom();
  }

  /** Say what it is for: beside the title, and to those who cannot see its plot. @param {string} text */
  help(text) {
    this.panel.title.title = text;
    this.plots[0].over.setAttribute("aria-label", text);
  }

  /** What files are asked for beside what its own slot asks. @returns {Record<string, any>} */
  get extra() {
    return {};
  }

  /** What is seen of its axes in pictures, too. @returns {{xlim?: number[], ylim?: number[]}} */
  get frame() {
    return framed(this.app.state.windows[this.id]);
  }

  resetZoom() {
    this.app.zoom(this.zoomed, null);
  }

  /** @param {string} slot @returns {Answer | undefined} */
  answer(slot) {
    return this.app.answers.get(slot);
  }

  /**
   * Whether something of an answer, or of a part of it, is seen here.
   * @param {string} slot @param {Part} [_part]
   */
  shows(slot, _part) {
    return this.slots.includes(slot);
  }

  /** @param {string} slot */
  emptyText(slot) {
    const { kind, reason } = this.app.standing(slot);
    return kind === "computing" || !reason ? "Computing …" : reason;
  }

  /** The state or an answer is new. */
  update() {}

  /** What is seen now. @returns {string} */
  sentence() {
    return "";
  }

  /** The motion's time is new. */
  tick() {}

  /** Whether it has something to show. @param {State} _state */
  isFor(_state) {
    return true;
  }

  /** The state or an answer is new: bring the picture and its sentence up to date. */
  show() {
    this.update();
    this.panel.say(this.sentence());
  }

  /** An answer or the colours are new. */
  refresh() {
    if (!this.isFor(this.app.state)) return;
    this.show();
    for (const plot of this.plots) plot.redraw();
  }
}
