/**
 * Who is attracted where: a strip below the event map, with the same horizontal axis.
 *
 * @import {App} from "../app.js"
 * @import {Part} from "../types.js"
 * @import {Plot} from "../plot.js"
 */
import { mark, named } from "../marks.js";
import { coordinateOf, startPoint, sticksAsOne, windowOf } from "../model.js";
import { listed, short } from "../numbers.js";
import { SANS, colors, nth } from "../theme.js";
import { View, framed } from "./view.js";

/** Labels of starts that end on no attractor. @type {[number, string][]} */
const REST = [
  [-2, "never stick together again"],
  [-1, "are not proved"],
];

export class BasinsView extends View {
  /** @param {App} app @param {Plot} above  of the map */
  constructor(app, above) {
    super(app, { id: "basins", title: "Basins", help: "", slots: ["basins"], export: "basins" });
    this.zoomed = "map";
    const plot = this.addPlot({ name: "Basins", xlabel: "d", ylabel: "", bare: true, left: 58, above });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => plot.vertical(startPoint(app.state), { color: colors().ink, width: 1.5 });
    plot.onclick = (x) => app.startAt(x);
    plot.onhover = (x) => this.read(x);
    plot.onzoom = (box) => {
      const kept = windowOf(app.state, "map");
      app.zoom("map", [box[0], box[1], kept?.[2] ?? box[0], kept?.[3] ?? box[1]]);
    };
    plot.onreset = () => this.resetZoom();
  }

  /** Its horizontal axis is that of the map. @override @param {string} slot @param {Part} [part] */
  shows(slot, part) {
    return super.shows(slot) || (slot === "map" && (!part || "domain" in part.data));
  }

  /** @override */
  get frame() {
    const { xlim } = framed(windowOf(this.app.state, "map"));
    return { xlim };
  }

  /** @returns {Part | undefined} */
  get part() {
    return this.answer("basins")?.parts.find((part) => part.arrays.label);
  }

  /** @returns {any[]} */
  get attractors() {
    return this.answer("basins")?.parts.find((part) => part.data.attractors)?.data.attractors ?? [];
  }

  /** Names of the attractors: of orbits those that the map gives them. */
  names() {
    const isOrbit = (/** @type {any} */ { kind }) => kind === "periodic";
    const look = { kind: "stable", stable: true, multiplier: null };
    const orbits = named(this.attractors.filter(isOrbit).map((one) => ({ ...one, ...look })));
    return this.attractors.map((one) => (isOrbit(one) ? orbits.shift()?.name : undefined) ?? name(one));
  }

  update() {
    const { edges } = this.part?.arrays ?? {};
    const whole = edges ? [edges[0], edges[edges.length - 1]] : [-1, 1];
    const [low, high] = windowOf(this.app.state, "map") ?? this.app.domain() ?? whole;
    this.plot.options.xlabel = coordinateOf(this.app.state);
    this.help(`Which attractor a motion from each ${this.app.written("d")} ends on. Click to start one.`);
    this.plot.setView([low, high, 0, 1], startPoint(this.app.state));
  }

  /** @override */
  sentence() {
    const shares = this.shares();
    if (!shares) return "";
    if (!this.attractors.length)
      return sticksAsOne(this.app.state.model)
        ? "No attractor is known: from no start do the blocks go on sticking together."
        : "No attractor is known: from no start does the motion go on returning to the domain.";
    const ends = this.names().map((who, k) => ({ share: shares[k], what: `end on ${who}` }));
    /** @type {[number, string][]} */
    const rest = sticksAsOne(this.app.state.model) ? REST : [[-2, "do not go on returning to the domain"], REST[1]];
    const told = [...ends, ...rest.map(([label, what]) => ({ share: shares[Number(label)] ?? 0, what }))]
      .filter(({ share }) => share > 5e-4)
      .map(({ share, what }) => `${percent(share)} ${what}`);
    const d = this.app.written("d");
    const map = windowOf(this.app.state, "map");
    return `Of ${map ? `the starts ${d} shown` : `all starts ${d}`} ${listed(told)}.${map ? "" : this.sampled(rest)}`;
  }

  /** Where samples of what is not proved end. @param {[number, string][]} rest */
  sampled(rest) {
    /** @type {number[]} */ const counts = this.part?.data.counts ?? [];
    const all = counts.reduce((a, b) => a + b, 0);
    const whats = [...this.names().map((who) => `end on ${who}`), rest[0][1], "are undecided"];
    const told = counts
      .map((count, k) => [count, whats[k]])
      .filter(([count]) => count)
      .map(([count, what]) => `${percent(Number(count) / all)} ${what}`);
    return told.length ? ` Of samples of these ${listed(told)}.` : "";
  }

  /** Of what is shown, or of all, by label; older values may be none of those shown. */
  shares() {
    if (!this.part) return null;
    const { edges, label } = this.part.arrays;
    const [low, high] = windowOf(this.app.state, "map") ?? [-Infinity, Infinity];
    const ends = [...edges].map((edge) => Math.min(high, Math.max(low, edge)));
    if (ends[0] === ends[ends.length - 1]) return null;
    /** @type {Record<number, number>} */ const shares = {};
    label.forEach((/** @type {number} */ k, /** @type {number} */ at) => {
      shares[k] = (shares[k] ?? 0) + (ends[at + 1] - ends[at]) / (ends[ends.length - 1] - ends[0]);
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
    const names = this.names();
    this.attractors.forEach((attractor, k) => {
      const points = attractor.points ?? [];
      for (const x of points) mark(plot, "disc", x, 0.22, { size: 3.5 });
      for (const [low, high] of attractor.bands ?? [])
        plot.segment(low, 0.22, high, 0.22, { width: 5 });
      this.#name(names[k], k);
    });
  }

  /** A name in the widest band shown. @param {string} text @param {number} k */
  #name(text, k) {
    const { plot } = this;
    const { context, left, right, top } = plot;
    const { edges, label } = /** @type {Part} */ (this.part).arrays;
    let [from, to] = [0, 0];
    label.forEach((/** @type {number} */ one, /** @type {number} */ at) => {
      const [a, b] = [Math.max(left, plot.x(edges[at])), Math.min(right, plot.x(edges[at + 1]))];
      if (one === k && b - a > to - from) [from, to] = [a, b];
    });
    context.font = `600 11px ${SANS}`;
    if (to - from < context.measureText(text).width + 8) return;
    context.textAlign = "center";
    context.textBaseline = "top";
    context.lineWidth = 3;
    context.strokeStyle = colors().panel;
    context.fillStyle = colors().ink;
    context.strokeText(text, (from + to) / 2, top + 3);
    context.fillText(text, (from + to) / 2, top + 3);
  }

  /** What is seen of a band, in one colour; every second attractor is hatched as well. */
  #band(/** @type {number} */ from, /** @type {number} */ to, /** @type {number} */ label) {
    const { plot } = this;
    const { context, top, bottom } = plot;
    const left = Math.max(plot.left, plot.x(from));
    const right = Math.min(plot.right, Math.max(plot.x(to), plot.x(from) + 0.75));
    if (label < 0 || !(right > left)) return;
    context.fillStyle = nth(label + 4).color;
    context.globalAlpha = 0.55;
    context.fillRect(left, top, right - left, bottom - top);
    context.globalAlpha = 1;
    if (label % 2 === 0 || right - left < 3) return;
    context.save();
    context.beginPath();
    context.rect(left, top, right - left, bottom - top);
    context.clip();
    context.beginPath();
    for (let x = Math.floor((left - bottom + top) / 7) * 7; x < right; x += 7) {
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
    const nowhere = sticksAsOne(this.app.state.model) ? "no further common stick" : "no further return to the domain";
    const who = this.names()[label[at]] ?? (label[at] === -2 ? nowhere : "not proved");
    return `${this.app.written("d")} = ${short(x, 7)}: ${who}\nfrom ${short(edges[at], 8)} to ${short(edges[at + 1], 8)}`;
  }
}

export const percent = (/** @type {number} */ share) => (share ? `${short(100 * share, 3)} %` : "none");

/** @param {any} attractor */
export const name = ({ kind, period }) =>
  kind === "periodic" ? `S${period}` : kind === "chaotic" ? "chaos" : kind;
