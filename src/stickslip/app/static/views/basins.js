/**
 * Who is attracted where: a strip below the event map, with the same horizontal axis.
 *
 * @import {App} from "../app.js"
 * @import {Part} from "../types.js"
 */
import { Labels, mark } from "../marks.js";
import { coordinateOf, sticksAsOne } from "../model.js";
import { listed, short } from "../numbers.js";
import { colors, nth } from "../theme.js";
import { View } from "./view.js";

export class BasinsView extends View {
  /** @param {App} app */
  constructor(app) {
    const help = "Which attractor a motion from each d ends on. Click to start one.";
    super(app, { id: "basins", title: "Basins", help, slots: ["basins"], export: "basins" });
    const plot = this.addPlot({ name: help, xlabel: "d", ylabel: "", bare: true, left: 58 });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => plot.vertical(app.state.d, { color: colors().ink, width: 1.5 });
    plot.onclick = (x) => app.startAt(x);
    plot.onhover = (x) => this.read(x);
    plot.onzoom = (box) => {
      const kept = app.state.windows.map;
      app.zoom("map", [box[0], box[1], kept?.[2] ?? box[0], kept?.[3] ?? box[1]]);
    };
    plot.onreset = () => app.zoom("map", null);
  }

  /** @returns {Part | undefined} */
  get part() {
    return this.answer("basins")?.parts.find((part) => part.arrays.label);
  }

  /** @returns {any[]} */
  get attractors() {
    return this.answer("basins")?.parts.find((part) => part.data.attractors)?.data.attractors ?? [];
  }

  update() {
    const { edges } = this.part?.arrays ?? {};
    const whole = edges ? [edges[0], edges[edges.length - 1]] : [-1, 1];
    const [low, high] = this.app.state.windows.map ?? this.app.domain() ?? whole;
    this.plot.options.xlabel = coordinateOf(this.app.state);
    this.plot.setView([low, high, 0, 1]);
  }

  /** @override */
  sentence() {
    const shares = this.shares();
    if (!shares) return "";
    const parts = this.attractors.map((one, k) => `${percent(shares[k])} end on ${name(one)}`);
    const rest = 1 - shares.reduce((sum, share) => sum + share, 0);
    if (!parts.length)
      return sticksAsOne(this.app.state.model)
        ? "No attractor is known: from no start do the blocks go on sticking together."
        : "No attractor is known: from no start does the motion go on returning.";
    if (rest > 5e-4) parts.push(`${percent(rest)} on none known`);
    return `Of all starts ${coordinateOf(this.app.state).replace("_", "")} ${listed(parts)}.`;
  }

  /** Of the whole domain. */
  shares() {
    if (!this.part) return null;
    const { edges, label } = this.part.arrays;
    const shares = this.attractors.map(() => 0);
    label.forEach((/** @type {number} */ k, /** @type {number} */ at) => {
      if (k >= 0) shares[k] += (edges[at + 1] - edges[at]) / (edges[edges.length - 1] - edges[0]);
    });
    return shares;
  }

  paint() {
    const { plot, part } = this;
    if (!part) return plot.message(this.emptyText("basins"));
    const { edges, label } = part.arrays;
    label.forEach((/** @type {number} */ k, /** @type {number} */ at) =>
      this.#band(edges[at], edges[at + 1], k),
    );
    const labels = new Labels(plot);
    this.attractors.forEach((attractor) => {
      const points = attractor.points ?? [];
      for (const x of points) mark(plot, "disc", x, 0.3, { size: 3.5 });
      for (const [low, high] of attractor.bands ?? [])
        plot.segment(low, 0.3, high, 0.3, { width: 5 });
      const at = points[0] ?? attractor.bands?.[0]?.[0];
      if (at !== undefined) labels.place(name(attractor), at, 0.45);
    });
  }

  /** A band of one colour; every second attractor is hatched as well. */
  #band(/** @type {number} */ from, /** @type {number} */ to, /** @type {number} */ label) {
    const { plot } = this;
    const { context, top, bottom } = plot;
    const [left, right] = [plot.x(from), plot.x(to)];
    if (label < 0) return;
    context.fillStyle = nth(label + 4).color;
    context.globalAlpha = 0.55;
    context.fillRect(left, top, Math.max(right - left, 0.75), bottom - top);
    context.globalAlpha = 1;
    if (label % 2 === 0 || right - left < 3) return;
    context.save();
    context.beginPath();
    context.rect(left, top, right - left, bottom - top);
    context.clip();
    context.beginPath();
    for (let x = Math.floor((left - 60) / 7) * 7; x < right; x += 7) {
      context.moveTo(x, bottom);
      context.lineTo(x + bottom - top, top);
    }
    context.lineWidth = 0.8;
    context.strokeStyle = colors().ink;
    context.globalAlpha = 0.45;
    context.stroke();
    context.restore();
  }

  /** @param {number} x */
  read(x) {
    const { part } = this;
    if (!part) return null;
    const { edges, label } = part.arrays;
    let at = label.length - 1;
    while (at > 0 && edges[at] > x) at--;
    const attractor = this.attractors[label[at]];
    const who = attractor ? name(attractor) : label[at] === -2 ? "no return" : "undecided";
    return `d = ${short(x, 7)}: ${who}\nfrom ${short(edges[at], 8)} to ${short(edges[at + 1], 8)}`;
  }
}

export const percent = (/** @type {number} */ share) => `${short(100 * share, 3)} %`;

/** @param {any} attractor */
export const name = ({ kind, period }) =>
  kind === "periodic" ? `S${period}` : kind === "chaotic" ? "chaos" : kind;
