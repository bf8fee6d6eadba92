/**
 * The bifurcation diagram, with the present parameter as a line to drag.
 *
 * @import {App} from "../app.js"
 * @import {Box, Numbers, Part} from "../types.js"
 * @import {Strand} from "../strands.js"
 */
import { BIFURCATIONS, Labels, mark } from "../marks.js";
import { noStrands, strands } from "../strands.js";
import { AWAY, bifurcationThings, told, under } from "../objects.js";
import { indexed, startPoint } from "../model.js";
import { short, span } from "../numbers.js";
import { colors } from "../theme.js";
import { OUTSIDE, View } from "./view.js";

const CLOSE = 16; // pixels between two of a kind that are named apart

/** What an attractor meets or ends at comes first. @param {{short: string}} bifurcation */
const rank = ({ short }) => Number(!["BC", "CR"].includes(short));

export class DiagramView extends View {
  /** @param {App} app */
  constructor(app) {
    const help =
      "Steady motions over a parameter. Drag the line, click to go there, drag a box to zoom.";
    super(app, {
      id: "diagram",
      title: "Bifurcation diagram",
      help,
      slots: ["diagram"],
      export: "diagram",
    });
    this.linked = { part: /** @type {Part | undefined} */ (undefined), strands: noStrands };
    const plot = this.addPlot({ name: help, xlabel: "", ylabel: "d" });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => this.paintOver();
    plot.grab = (px) => (Math.abs(px - plot.x(app.parameter)) < 6 ? (x) => app.goTo(x) : null);
    plot.onclick = (x, y) => (this.thing(x, y)?.go ?? (() => app.goTo(x, y)))(0);
    plot.onhover = (x, y) => this.read(x, y);
    this.zoomable(plot);
  }

  /** The range is what is asked for. @override */
  get frame() {
    const { view } = this.app.state.diagram;
    return view ? { ylim: view } : {};
  }

  get parts() {
    return this.answer("diagram")?.parts ?? [];
  }

  /** @returns {any[]} */
  get bifurcations() {
    return this.parts.find((part) => part.data.bifurcations)?.data.bifurcations ?? [];
  }

  update() {
    const { parameter, state } = this.app;
    const { diagram } = state;
    this.plot.options.xlabel = indexed(this.app.symbol(diagram.parameter));
    this.plot.options.ylabel = this.app.symbol("d");
    const vertical = diagram.view ?? diagram.window ?? this.extent();
    this.plot.setView(/** @type {Box} */ ([...diagram.range, ...vertical]), parameter, startPoint(state));
  }

  /** @override */
  sentence() {
    const { app } = this;
    if (!this.parts.some((part) => part.data.bifurcations)) return "";
    const { parameter, range } = app.state.diagram;
    const beside = app.parameter < range[0] ? "left" : app.parameter > range[1] ? "right" : "";
    const where = beside ? `${beside} of what is shown` : "the line";
    const here = `At ${app.written(parameter)} = ${short(app.parameter, 6)}, ${where}`;
    const things = bifurcationThings(app);
    const off = this.isOutside ? OUTSIDE : "";
    if (!things.length) return `${here}: nothing changes in this range.${off}`;
    const ahead = things.find(({ at }) => at > app.parameter);
    const { at, of, why } = ahead ?? things[things.length - 1];
    const place = `${ahead ? "next on the right" : "behind"}, at ${short(at, 8)}`;
    return `${here}; ${place}: ${of.kind.replaceAll("_", " ")}${why && `, ${why.split(AWAY)[0]}`}.${off}`;
  }

  /** @returns {Part | undefined} */
  get branches() {
    return this.parts.find((part) => "parameter" in part.data);
  }

  /**
   * Arrays of dots, as pairs: the first quick ones until the settled ones are known.
   * @returns {[Numbers, Numbers][]}
   */
  get dots() {
    const settled = this.branches?.arrays;
    if (settled?.dot_d.length) return [[settled.dot_value, settled.dot_d]];
    return this.parts
      .filter(({ data }) => data.part_name === "dots")
      .map(({ arrays }) => [arrays.value, arrays.d]);
  }

  /** Whether points are known, and none of them lies in the view. */
  get isOutside() {
    const [, , low, high] = this.plot.view; // what is drawn by now may be of the view before
    const orbits = Object.entries(this.branches?.arrays ?? {}).filter(([name]) => name.startsWith("points_"));
    /** @type {(Numbers | number[])[]} */ const all = [...this.dots, ...orbits].map(([, ys]) => ys);
    all.push(...this.throughJumps.map(({ ys }) => ys));
    const some = (/** @type {(y: number) => boolean} */ is) => all.some((ys) => ys.some(is));
    return some(Number.isFinite) && !some((y) => y >= low && y <= high);
  }

  /** What the dots span. */
  extent() {
    const [low, high] = span(...this.dots.map(([, points]) => points));
    if (!(high >= low)) return this.app.domain() ?? [-1, 1];
    const pad = 0.06 * (high - low) || 0.1;
    return [low - pad, high + pad];
  }

  paint() {
    const { plot, branches } = this;
    if (!this.parts.length) return plot.message(this.emptyText("diagram"));
    const of = colors();
    /** @type {{arrays: Record<string, Numbers>, data: any}} */
    const { arrays, data } = branches ?? { arrays: {}, data: { breakpoints: [], orbits: [] } };
    data.breakpoints.forEach((/** @type {any} */ _, /** @type {number} */ k) => {
      plot.line(arrays.value, arrays[`break_${k}`], { color: of.muted, dash: [6, 4], width: 1 });
    });
    const wide = this.column;
    for (const [value, d] of this.dots)
      plot.dots(value, d, { color: of.blue, size: 1.3, alpha: 0.45, wide });
    data.orbits.forEach((/** @type {any} */ orbit, /** @type {number} */ k) => {
      this.#orbit(arrays.value, arrays[`points_${k}`], arrays[`multiplier_${k}`], orbit);
    });
    for (const { xs, ys } of this.throughJumps)
      if (xs.length > 1) plot.line(xs, ys, { color: of.purple, width: 1, dash: [5, 2] });
      else plot.dots(xs, ys, { color: of.purple, size: 2.2 });
    this.#marks();
  }

  /** Pixels from one value with dots to the next: dots as wide as that leave no gaps. */
  get column() {
    const values = [...new Set(this.dots.flatMap(([some]) => [...some]))].sort((a, b) => a - b);
    const [first, last] = [this.plot.x(values[0]), this.plot.x(values[values.length - 1])];
    return values.length > 1 ? (last - first) / (values.length - 1) : 0;
  }

  /** Curves of the orbits through a jump. @returns {Strand[]} */
  get throughJumps() {
    const part = this.parts.find(({ data }) => data.part_name === "infinitely_unstable");
    if (part !== this.linked.part)
      this.linked = { part, strands: part ? strands(part.arrays, this.bifurcations) : [] };
    return this.linked.strands;
  }

  /**
   * An orbit from its first end to its last: heavy where it is stable, thin where it is not.
   * @param {Numbers} values @param {Numbers} points @param {Numbers} multiplier @param {any} orbit
   */
  #orbit(values, points, multiplier, { period, ends: [first, last] }) {
    const exists = (/** @type {number} */ k) => Number.isFinite(multiplier[k]);
    let [from, to] = [0, multiplier.length - 1];
    while (from < to && !exists(from)) from++;
    while (to > from && !exists(to)) to--;
    const inner = Array.from({ length: to - from + 1 }, (_, k) => from + k).filter(exists);
    const stable = inner.map((k) => Math.abs(multiplier[k]) < 1);
    const xs = [first.value, ...inner.map((k) => values[k]), last.value];
    const kinds = [stable[0], ...stable, stable.at(-1)];
    for (let strand = 0; strand < period; strand++) {
      const ys = [
        first.points[strand],
        ...inner.map((k) => points[k * period + strand]),
        last.points[strand],
      ];
      for (const [wanted, look] of /** @type {const} */ ([
        [false, { color: colors().vermillion, width: 1 }],
        [true, { color: colors().ink, width: 2.4 }],
      ])) {
        // A thin line reaches to where the heavy one begins.
        const shown = ys.map((y, k) =>
          kinds[k] === wanted || (!wanted && (kinds[k - 1] === wanted || kinds[k + 1] === wanted))
            ? y
            : NaN,
        );
        this.plot.line(xs, shown, look);
      }
    }
  }

  #marks() {
    const { plot } = this;
    const labels = new Labels(plot);
    for (const item of this.bifurcations) {
      const [shape, color] = BIFURCATIONS[item.short] ?? ["up", "ink"];
      for (const point of item.points) {
        mark(plot, shape, item.value, point, { color: colors()[color], size: 5 });
        labels.avoid(item.value, point, 6);
      }
    }
    // Of a cascade the first ones are named first, and what changes most.
    const inOrder = [...this.bifurcations].sort(
      (a, b) => rank(a) - rank(b) || (a.period ?? 0) - (b.period ?? 0),
    );
    const named = new Set();
    for (const { short, value, points } of inOrder) {
      const near = `${short} ${Math.round(plot.x(value) / CLOSE)}`;
      if (named.has(near)) continue; // one name does for them
      named.add(near);
      for (const point of points.slice(0, 4)) labels.place(short, value, point);
    }
  }

  paintOver() {
    const { plot, app } = this;
    plot.vertical(app.parameter, { color: colors().slip, width: 1.5 });
    mark(plot, "up", app.parameter, plot.dataY(plot.bottom - 6), { color: colors().slip, size: 6 });
    mark(plot, "ring", app.parameter, startPoint(app.state), { color: colors().slip, size: 4 });
  }

  /** What is marked there. @param {number} x @param {number} y */
  thing(x, y) {
    const marks = bifurcationThings(this.app).map((thing) => ({
      thing,
      spots: thing.of.points.map((/** @type {number} */ point) => [thing.at, point]),
    }));
    return under(this.plot, x, y, marks);
  }

  /** @param {number} x @param {number} y @returns {import("../plot.js").Tip} */
  read(x, y) {
    const thing = this.thing(x, y);
    if (thing) return told(thing);
    const { app } = this;
    return `${app.written(app.state.diagram.parameter)} = ${short(x, 7)}, ${app.written("d")} = ${short(y, 5)}`;
  }
}
