/**
 * The friction law: force on a block over its velocity relative to the belt.
 *
 * @import {App} from "../app.js"
 * @import {Box} from "../types.js"
 */
import { mark } from "../marks.js";
import { hasLaws } from "../model.js";
import { column, short } from "../numbers.js";
import { colors, nth } from "../theme.js";
import { View } from "./view.js";

export class LawView extends View {
  /** @param {App} app */
  constructor(app) {
    const help =
      "Friction force, over the static limit, against the velocity relative to the belt.";
    super(app, { id: "law", title: "Friction law", help, slots: ["law"], export: "law" });
    const plot = this.addPlot({ name: help, xlabel: "w", ylabel: "F" });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => this.paintOver();
    plot.onhover = (x, y) => `w = ${short(x, 4)}, force ${short(y, 4)}`;
  }

  update() {
    const part = this.answer("law")?.parts[0];
    if (!part) return this.plot.redraw();
    const { s } = part.arrays;
    const reach = s[s.length - 1];
    this.plot.setView(/** @type {Box} */ ([-reach, reach, -1.15, 1.15]));
  }

  /** @override */
  sentence() {
    const part = this.answer("law")?.parts[0];
    if (!part) return "";
    const { s, forward } = part.arrays;
    const [w, force] = [s, forward].map((values) => short(values.at(-1), 3));
    return `Up to 1 in stick, ${force} at w = ${w}.`;
  }

  paint() {
    const part = this.answer("law")?.parts[0];
    const { plot } = this;
    if (!part) return plot.message(this.emptyText("law"));
    const { s, force, forward } = part.arrays;
    const count = force.length / s.length;
    const different = hasLaws(this.app.state.model) ? count : 1;
    plot.horizontal(0, { color: colors().muted, width: 0.8 });
    const ahead = s.map((value) => -value);
    for (let block = 0; block < different; block++) {
      const look = { ...nth(block), width: 1.8 };
      plot.line(ahead, column(force, block, count), look);
      plot.line(
        s,
        column(forward, block, count).map((value) => -value),
        look,
      );
    }
    plot.segment(0, -1, 0, 1, { color: colors().stick, width: 3 });
  }

  /** Where each block is now: its force over its static limit. */
  paintOver() {
    const { clock } = this.app;
    const k = clock.index();
    const data = clock.motion?.parts[0]?.data;
    if (k < 0 || !data) return;
    const { w, force, mode, limit } = clock.arrays;
    data.contacts.forEach((/** @type {any} */ contact, /** @type {number} */ which) => {
      const at = k * data.contacts.length + which;
      const rides = mode[at] === 0;
      const color = rides ? colors().stick : colors().slip;
      const share = force[at] / (limit ? limit[at] : contact.limit);
      mark(this.plot, rides ? "disc" : "ring", w[at] - contact.V, share, { color, size: 4.5 });
    });
  }

  tick() {
    this.plot.redrawOver();
  }
}
