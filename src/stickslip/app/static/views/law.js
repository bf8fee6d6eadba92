/**
 * The friction law: force on a block over its velocity relative to the belt.
 *
 * @import {App} from "../app.js"
 * @import {Box} from "../types.js"
 */
import { mark } from "../marks.js";
import { hasLaws } from "../model.js";
import { column, listed, nearest, short, span } from "../numbers.js";
import { colors, nth } from "../theme.js";
import { View } from "./view.js";

export class LawView extends View {
  /** @param {App} app */
  constructor(app) {
    const help =
      "Friction force, over the static limit, against the velocity relative to the belt. The arrow keys read it.";
    super(app, { id: "law", title: "Friction law", help, slots: ["law"], export: "law" });
    const plot = this.addPlot({ name: help, xlabel: "w", ylabel: "F" });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => this.paintOver();
    let held = 0;
    plot.held = () => held;
    plot.onclick = (w) => (held = w);
    plot.onhover = (w) => this.read(w);
  }

  /** Slip speeds, and of each law the forces against backward and forward slip. */
  get curves() {
    const answer = this.answer("law");
    const arrays = answer?.parts[0]?.arrays;
    if (!answer || !arrays) return null;
    const { s, force, forward } = arrays;
    const count = force.length / s.length;
    const laws = Array.from({ length: hasLaws(answer.question.request.model) ? count : 1 }, (_, k) => ({
      back: column(force, k, count),
      ahead: column(forward, k, count).map((value) => -value),
    }));
    return { s, laws };
  }

  update() {
    const { curves } = this;
    if (!curves) return this.plot.redraw();
    const reach = curves.s[curves.s.length - 1];
    const [low, high] = span([-1, 1], ...curves.laws.flatMap(({ back, ahead }) => [back, ahead]));
    const room = 0.12 * (high - low);
    this.plot.setView(/** @type {Box} */ ([-reach, reach, low - room, high + room]));
  }

  /** The force at a velocity, in words; of laws that differ there each. @param {number} w */
  read(w) {
    const { curves } = this;
    if (!curves) return "";
    const k = nearest(curves.s, Math.abs(w));
    const values = curves.laws.map(({ back, ahead }) => short((w < 0 ? back : ahead)[k], 3));
    const sign = w < 0 ? "−" : "";
    const at = k ? listed([...new Set(values)]) : "from −1 to 1, in stick";
    return `w = ${sign}${short(curves.s[k], 3)}: F = ${at}`;
  }

  /** @override */
  sentence() {
    const { curves } = this;
    return curves ? `In stick from −1 to 1; at ${this.read(curves.s[curves.s.length - 1])}.` : "";
  }

  paint() {
    const { plot, curves } = this;
    if (!curves) return plot.message(this.emptyText("law"));
    plot.horizontal(0, { color: colors().muted, width: 0.8 });
    const minus = curves.s.map((value) => -value);
    curves.laws.forEach(({ back, ahead }, k) => {
      const look = { ...nth(k), width: 1.8 };
      plot.line(minus, back, look);
      plot.line(curves.s, ahead, look);
    });
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
