/**
 * Who is attracted where, of three blocks or more: the plane of the first two differences.
 *
 * @import {App} from "../app.js"
 * @import {Part} from "../types.js"
 */
import { Labels, mark } from "../marks.js";
import { coordinatesOf, sticksAsOne } from "../model.js";
import { listed, short, spelled } from "../numbers.js";
import { colors, nth } from "../theme.js";
import { name, percent } from "./basins.js";
import { View } from "./view.js";

export class SectionView extends View {
  /** @param {App} app */
  constructor(app) {
    super(app, { id: "section", title: "Basins", help: "", slots: ["basins"], export: "basins" });
    const plot = this.addPlot({ name: "Basins", xlabel: "d_1", ylabel: "d_2" });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.onhover = (x, y) => this.read(x, y);
    this.zoomable(plot);
  }

  get nowhere() {
    return sticksAsOne(this.app.state.model) ? "no global stick" : "no further return to the domain";
  }

  /** What the first two numbers of a point are. */
  get axes() {
    const names = coordinatesOf(this.app.state);
    return names[0] === names[1] ? ["d_1", "d_2"] : names;
  }

  /** The finest picture so far. @returns {Part | undefined} */
  get part() {
    return this.answer("basins")?.parts.findLast((part) => part.arrays.index);
  }

  /** @returns {any[]} */
  get attractors() {
    return this.answer("basins")?.parts.find((part) => part.data.attractors)?.data.attractors ?? [];
  }

  /** Names of the attractors; those of one kind have a letter each. */
  names() {
    const plain = this.attractors.map(name);
    const same = (/** @type {string} */ text) => plain.filter((other) => other === text).length;
    const letter = (/** @type {number} */ k) =>
      String.fromCharCode(97 + plain.slice(0, k).filter((text) => text === plain[k]).length);
    return plain.map((text, k) => (same(text) > 1 ? text + letter(k) : text));
  }

  update() {
    const { x, y } = this.part?.arrays ?? { x: [-1, 1], y: [-1, 1] };
    const whole = /** @type {[number, number, number, number]} */ ([
      ...[x[0], x[x.length - 1]],
      ...[y[0], y[y.length - 1]],
    ]);
    const { options } = this.plot;
    const [first, second] = this.axes;
    Object.assign(options, { xlabel: first, ylabel: second });
    const starts = sticksAsOne(this.app.state.model) ? "global stick phase" : "point of the return map";
    this.help(`Which attractor a motion from each ${starts} ends on.`);
    this.plot.setView(this.app.state.windows.section ?? whole);
  }

  /** @override */
  sentence() {
    const { part } = this;
    if (!part) return "";
    if (!this.attractors.length)
      return "No attractor is known: from no start does the motion go on returning to the domain.";
    const { shares, held, mistaken, checked } = part.data;
    const ends = this.names().map((who, k) => `${percent(shares[k])} end on ${who}`);
    const where = held ? " in this section, other numbers 0," : "";
    const wrong = mistaken ? ` ${mistaken} of ${checked} checked came elsewhere.` : "";
    const who = sticksAsOne(this.app.state.model) ? "starts" : "starts whose motion returns";
    return `Of the ${who}${where} ${listed(ends)}: by sampling, no proof.${wrong}`;
  }

  paint() {
    const { plot, part } = this;
    if (!part) return plot.message(this.emptyText("basins"));
    const { x, y, index } = part.arrays;
    const { context } = plot;
    const lefts = borders(x).map((at) => Math.round(plot.x(at)));
    const lows = borders(y).map((at) => Math.round(plot.y(at)));
    context.globalAlpha = 0.55;
    for (let i = 0; i < x.length; i++) {
      const [left, right] = [lefts[i], lefts[i + 1]];
      for (let j = 0, from = 0; j < y.length; j = from) {
        const label = index[i * y.length + j];
        for (from = j + 1; from < y.length && index[i * y.length + from] === label; from++);
        if (label < -1) continue; // outside the locus, or no return
        const [low, high] = [lows[j], lows[from]];
        context.fillStyle = label < 0 ? colors().muted : nth(label + 4).color;
        context.fillRect(left, high, right - left, low - high);
      }
    }
    context.globalAlpha = 1;
    const labels = new Labels(plot);
    const names = this.names();
    this.attractors.forEach(({ points, kind }, k) => {
      if (!points.length) return;
      for (const [px, py] of points)
        mark(plot, "disc", px, py, { size: kind === "periodic" ? 3.5 : 1 });
      labels.place(names[k], points[0][0], points[0][1]);
    });
  }

  /** @param {number} px @param {number} py */
  read(px, py) {
    const { part } = this;
    if (!part) return null;
    const { x, y, index } = part.arrays;
    const [i, j] = [nearest(x, px), nearest(y, py)];
    const label = index[i * y.length + j];
    const who = label >= 0 ? this.names()[label] : label === -1 ? "undecided" : this.nowhere;
    const [first, second] = this.axes.map(spelled);
    return `${first} = ${short(px, 5)}, ${second} = ${short(py, 5)}: ${who}`;
  }
}

/** Where cells about equidistant numbers meet: one more than these. @param {ArrayLike<number>} values */
const borders = (values) =>
  Array.from({ length: values.length + 1 }, (_, k) => values[0] + (k - 0.5) * (values[1] - values[0]));

/** Of equidistant numbers. @param {ArrayLike<number>} values @param {number} at */
const nearest = (values, at) => {
  const k = Math.round((at - values[0]) / (values[1] - values[0]));
  return Math.max(0, Math.min(values.length - 1, k));
};
