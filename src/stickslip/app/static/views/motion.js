/**
 * Views of the motion in time: phase portraits, plane of displacements, stick and slip over time.
 *
 * @import {App} from "../app.js"
 * @import {Box, Model, Numbers} from "../types.js"
 */
import { mark } from "../marks.js";
import { blockCount, isStructure } from "../model.js";
import { column, short, span } from "../numbers.js";
import { Plot } from "../plot.js";
import { SANS, colors } from "../theme.js";
import { View } from "./view.js";

/**
 * Smallest box around values, with some room.
 * @param {Iterable<number>[]} xs
 * @param {Iterable<number>[]} ys
 * @param {Iterable<number>[]} [others]  displacements and velocities beside which these may be rounding
 * @returns {Box}
 */
function around(xs, ys, others = [[], []]) {
  return /** @type {Box} */ (
    [xs, ys].flatMap((lists, axis) => {
      const [low, high] = span(...lists);
      if (!(high >= low)) return [-1, 1];
      const dust = 1e-9 * Math.max(...span(...lists, others[axis]).map(Math.abs)); // rounding is no motion
      const pad = high - low > dust ? 0.07 * (high - low) : 0.1;
      return [low - pad, high + pad];
    })
  );
}

const FINE = 3000; // samples of a motion between which straight lines are seen as none

/**
 * A motion that has few samples with more: on cubics that have their displacements and velocities.
 * @param {Numbers} t @param {Numbers} x @param {Numbers} v
 */
function smooth(t, x, v) {
  /** @type {[number, number][]} */ const points = [];
  for (let k = 0; k < t.length; k++) {
    points.push([x[k], v[k]]);
    const h = t[k + 1] - t[k];
    const count = Math.ceil((FINE * h) / t[t.length - 1]); // none between two that are close: they are rounded
    const mean = (x[k + 1] - x[k]) / h;
    for (let part = 1; part < count; part++) {
      const s = part / count;
      const bend = 3 * (1 - s) * s * (2 * mean - v[k] - v[k + 1]);
      const from = v[k] * (1 - s) ** 2 - v[k + 1] * s * (1 - s) + mean * s * (3 - 2 * s);
      points.push([x[k] + h * s * from, v[k] + s * (v[k + 1] - v[k]) + bend]);
    }
  }
  return { x: Float64Array.from(points, ([x]) => x), v: Float64Array.from(points, ([, v]) => v) };
}

/**
 * What a contact is called: after its block, or by its number and the bodies that it joins.
 * @param {Model} model @param {{bodies: number[], elastic: boolean}} contact @param {number} k
 */
export function contactName(model, { bodies, elastic }, k) {
  if (!isStructure(model)) return `Block ${k + 1}`;
  const [one, other] = bodies.map((body) => body + 1);
  const joins = other ? `body ${one} on body ${other}` : one && `${elastic ? "foot of " : ""}body ${one}`;
  return `Contact ${k + 1}${joins ? ` (${joins})` : ""}`;
}

/**
 * Axes of its portrait: displacement and velocity along it.
 * @param {Model} model @param {{bodies: number[], elastic: boolean}} contact @param {number} k
 */
function axesOf(model, { bodies, elastic }, k) {
  const [one, other] = isStructure(model) ? bodies.map((body) => body + 1) : [k + 1];
  if (elastic || !one) return ["x", "x′"];
  return ["X", "X′"].map((name) => (other ? `${name}_${one} − ${name}_${other}` : `${name}_${one}`));
}

export class PortraitView extends View {
  /** @param {App} app @param {number} block  from 0 */
  constructor(app, block) {
    super(app, {
      id: `portrait-${block + 1}`,
      title: `Contact ${block + 1}`,
      help: "",
      slots: ["motion"],
      export: "portrait",
    });
    this.panel.section.classList.add("panel-portrait");
    this.block = block;
    const plot = this.addPlot({ name: "Phase portrait", xlabel: "", ylabel: "" });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => this.paintOver();
    plot.onhover = (x, y) => `X = ${short(x, 4)}, X′ = ${short(y, 4)}`;
    this.zoomable(plot);
  }

  /** @override */
  get extra() {
    return { block: this.block + 1 };
  }

  update() {
    const { arrays } = this.app.clock;
    const { block } = this;
    if (!arrays) this.of = this.x = undefined;
    const contact = this.answer("motion")?.parts[0]?.data.contacts[block];
    const count = arrays ? arrays.mode.length / arrays.t.length : 0;
    if (!this.of) this.panel.name(contactName(this.app.state.model, { bodies: [], elastic: false }, block));
    if (arrays && contact && block < count && arrays !== this.of) {
      this.of = arrays;
      this.count = count;
      this.contact = contact;
      const { model } = this.app.clock;
      const name = contactName(model, contact, block);
      this.panel.name(name);
      const does = contact.V ? "rides on its belt" : "sticks";
      this.help(`Velocity over displacement of ${name.toLowerCase()}; heavy where it ${does}.`);
      const [x, v] = axesOf(model, contact, block);
      Object.assign(this.plot.options, { xlabel: x, ylabel: v });
      this.x = column(arrays.u, block, count);
      this.v = column(arrays.w, block, count);
      const rides = column(arrays.mode, block, count).map((mode) => Number(mode === 0));
      this.slips = this.v.map((v, k) => (rides[k] && rides[k - 1] && rides[k + 1] ? NaN : v));
      this.rides = this.v.map((v, k) => (rides[k] ? v : NaN));
      // Displacements along contacts of structures need not have these velocities for rates.
      this.path = arrays.u === arrays.x ? smooth(arrays.t, this.x, this.slips) : { x: this.x, v: this.slips };
      this.whole = around([this.x], [this.v], [arrays.x, arrays.v]);
    }
    const whole = this.of ? this.whole : undefined;
    this.plot.setView(this.app.state.windows[this.id] ?? whole ?? around([], []));
  }

  /** @override */
  sentence() {
    if (!this.of || !this.rides) return "";
    const { t } = this.of;
    let riding = 0;
    for (let k = 1; k < t.length; k++) // events are among the times; what is told of one holds after it
      if (!Number.isNaN(this.rides[k - 1])) riding += t[k] - t[k - 1];
    const sticks = this.contact?.V ? "Rides" : "Sticks";
    return `${sticks} ${short((100 * riding) / (t.at(-1) || 1), 3)} % of the time (heavy); thin: slips.`;
  }

  paint() {
    const { plot } = this;
    if (!this.x || !this.v) return plot.message(this.emptyText("motion"));
    const of = colors();
    plot.horizontal(this.V, { color: of.muted, width: 1, dash: [5, 4] });
    if (this.path) plot.line(this.path.x, this.path.v, { width: 1 });
    plot.line(this.x, /** @type {any} */ (this.rides), { color: of.stick, width: 3 });
    if (this.V) return;
    this.rides?.forEach((v, k, rides) => {
      const begins = Number.isNaN(rides[k - 1] ?? NaN); // at rest it stays there: a line of no length
      if (begins) mark(plot, "disc", this.x?.[k] ?? NaN, v, { color: of.stick, size: 3 });
    });
  }

  get V() {
    return this.contact?.V ?? 0;
  }

  paintOver() {
    const { plot, block, count = 0 } = this;
    const k = this.app.clock.index();
    const { arrays } = this.app.clock;
    if (k < 0 || !this.x || !this.v || arrays !== this.of) return;
    const of = colors();
    if (arrays.interval) {
      const [low, high] = [0, 1].map((end) => arrays.interval[2 * (k * count + block) + end]);
      if (Number.isNaN(low)) return this.markNow(k);
      const y = plot.y(this.V);
      plot.segment(low, this.V, high, this.V, { color: of.stick, width: 1.2, alpha: 0.8 });
      for (const end of [low, high]) {
        plot.segment(end, plot.dataY(y + 6), end, plot.dataY(y - 6), {
          color: of.stick,
          width: 1.6,
        });
      }
    }
    this.markNow(k);
  }

  /** Where it is now. @param {number} k */
  markNow(k) {
    const rides = this.of.mode[k * (this.count ?? 0) + this.block] === 0;
    mark(this.plot, rides ? "disc" : "ring", this.x?.[k] ?? NaN, this.v?.[k] ?? NaN, {
      color: rides ? colors().stick : colors().slip,
      size: 5,
    });
  }

  /** @override @param {any} state */
  isFor({ model }) {
    return this.block < blockCount(model);
  }

  tick() {
    this.plot.redrawOver();
  }
}

export class PlaneView extends View {
  /** @param {App} app */
  constructor(app) {
    const help = "The plane of displacements: where both blocks can ride (shaded), and the motion.";
    super(app, {
      id: "plane",
      title: "Displacements",
      help,
      slots: ["motion", "locus"],
      export: "plane",
    });
    const plot = this.addPlot({ name: help, xlabel: "X_1", ylabel: "X_2", equal: true });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => this.paintOver();
    plot.onhover = (x, y) => `X₁ = ${short(x, 4)}, X₂ = ${short(y, 4)}\nd = ${short(y - x, 5)}`;
    this.zoomable(plot);
  }

  get locus() {
    return this.answer("locus")?.parts[0]?.data;
  }

  update() {
    const { arrays } = this.app.clock;
    if (!arrays) this.of = this.x = undefined;
    if (arrays && this.isFor(this.app.state) && arrays.x.length === 2 * arrays.t.length && arrays !== this.of) {
      this.of = arrays;
      this.x = [0, 1].map((k) => column(arrays.x, k, 2));
      this.path = this.x.map((x, k) => smooth(arrays.t, x, column(arrays.v, k, 2)).x);
      const both = Uint8Array.from(arrays.t, (_, k) =>
        Number(arrays.mode[2 * k] + arrays.mode[2 * k + 1] === 0),
      );
      this.glide = this.x[1].map((x, k) => (both[k] ? x : NaN));
    }
    const corners = this.locus?.corners ?? [];
    const [xs, ys] = [0, 1].map((axis) => corners.map((/** @type {number[]} */ c) => c[axis]));
    this.plot.setView(
      this.app.state.windows.plane ?? around([xs, this.x?.[0] ?? []], [ys, this.x?.[1] ?? []]),
    );
  }

  /** @override */
  sentence() {
    return this.locus
      ? "Shaded: both can ride; at the green edge block 1 slips, at the red block 2."
      : "";
  }

  paint() {
    const { plot, locus, x } = this;
    const of = colors();
    if (!locus) return plot.message(this.emptyText("locus"));
    plot.polygon(locus.corners, of.fill);
    const [a, b, c, d] = locus.corners;
    plot.line([a[0], b[0], c[0], d[0], a[0]], [a[1], b[1], c[1], d[1], a[1]], {
      color: of.muted,
      width: 1,
    });
    plot.segment(a[0], a[1], c[0], c[1], { color: of.muted, width: 1, dash: [5, 3] });
    locus.edges.forEach((/** @type {any} */ { from, to }, /** @type {number} */ k) => {
      const look = k === 0 ? { color: of.green } : { color: of.vermillion, dash: [7, 2] };
      plot.segment(from[0], from[1], to[0], to[1], { width: 2.5, ...look });
    });
    if (!x || !this.path) return;
    plot.line(this.path[0], this.path[1], { width: 0.9, alpha: 0.8 });
    plot.line(x[0], /** @type {any} */ (this.glide), { color: of.stick, width: 3 });
  }

  paintOver() {
    const k = this.app.clock.index();
    if (k < 0 || !this.x || this.app.clock.arrays !== this.of) return;
    const rides = !Number.isNaN(this.glide?.[k]);
    mark(this.plot, rides ? "disc" : "ring", this.x[0][k], this.x[1][k], {
      color: rides ? colors().stick : colors().slip,
      size: 5,
    });
  }

  tick() {
    this.plot.redrawOver();
  }
}

const NAME = 11; // height of a lane's name, pixels
const NUMBERED = 22; // left of lanes with a block's number
const NAMED = 64; // ... with the name of a contact

/** A lane for each block: a bar while it rides, a line while it slips; click to go to that time. */
export class Timeline {
  /** @param {App} app @param {HTMLElement} host */
  constructor(app, host) {
    this.app = app;
    const plot = new Plot(host, {
      name: "Stick and slip over time. Click, or the arrow keys, go to another time.",
      xlabel: "t",
      ylabel: "",
      bare: true,
      left: NUMBERED,
    });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintMargin = () => this.names();
    plot.paintOver = () => plot.vertical(app.clock.t, { width: 1.5 });
    plot.onclick = (x) => app.clock.seek(x);
    plot.grab = () => (x) => app.clock.seek(x);
    plot.held = () => app.clock.t;
    plot.onhover = (x, y) => this.read(x, y);
  }

  update() {
    const { model } = this.app.clock;
    this.plot.options.left = model && isStructure(model) ? NAMED : NUMBERED;
    this.plot.setView([0, this.app.clock.end || 1, 0, 1]);
  }

  paint() {
    const { plot } = this;
    const { arrays } = this.app.clock;
    if (!arrays) return;
    const { t, mode } = arrays;
    const count = mode.length / t.length;
    const { context, top, bottom } = plot;
    const lane = (bottom - top) / count;
    const of = colors();
    for (let block = 0; block < count; block++) {
      const middle = top + lane * (block + 0.5);
      plot.segment(plot.shown[0], plot.dataY(middle), plot.shown[1], plot.dataY(middle), {
        color: of.slip,
        width: 1.5,
      });
      context.fillStyle = of.stick;
      let from = -1;
      for (let k = 0; k <= t.length; k++) {
        const rides = k < t.length && mode[k * count + block] === 0;
        if (rides && from < 0) from = k;
        if (rides || from < 0) continue;
        const left = plot.x(t[from]);
        context.fillRect(
          left,
          middle - 0.3 * lane,
          Math.max(1, plot.x(t[Math.min(k, t.length - 1)]) - left),
          0.6 * lane,
        );
        from = -1;
      }
    }
  }

  /** The time, and whose lane it is. @param {number} t @param {number} y */
  read(t, y) {
    const { model, motion } = this.app.clock;
    const contacts = motion?.parts[0]?.data.contacts ?? [];
    const lane = Math.floor((1 - y) * contacts.length);
    const who = contacts[lane] ? `${contactName(model, contacts[lane], lane)}, ` : "";
    return `${who}t = ${short(t, 4)}`;
  }

  /** Whose lanes they are, as many as there is room for: contacts are not numbered as bodies are. */
  names() {
    const { arrays, model } = this.app.clock;
    if (!arrays) return;
    const { context, left, top, bottom } = this.plot;
    const count = arrays.mode.length / arrays.t.length;
    context.font = `600 ${NAME}px ${SANS}`;
    context.fillStyle = colors().ink;
    context.textAlign = "right";
    context.textBaseline = "middle";
    const lane = (bottom - top) / count;
    for (let block = 0; block < count; block += Math.ceil(NAME / lane)) {
      const who = isStructure(model) ? `contact ${block + 1}` : String(block + 1);
      context.fillText(who, left - 6, top + lane * (block + 0.5));
    }
  }
}
