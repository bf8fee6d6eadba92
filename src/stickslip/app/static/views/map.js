/**
 * The event map, or a power of it: branches, breakpoints, orbits, cobweb.
 *
 * @import {App, Answer} from "../app.js"
 * @import {Orbit, Part, State, Box} from "../types.js"
 */
import { Labels, mark, orbitName, orbitShape } from "../marks.js";
import { Plot } from "../plot.js";
import { colors, nth } from "../theme.js";
import { nearest, short } from "../numbers.js";
import { View } from "./view.js";

const NEAR = 7; // pixels within which the pointer means a point
const LEFT = 58;

export class MapView extends View {
  /** @param {App} app @param {"map" | "power"} slot */
  constructor(app, slot) {
    const main = slot === "map";
    const help = main
      ? "From one global stick phase to the next: d = X₂ − X₁. Click to start a motion, drag to zoom."
      : "The event map applied several times: its fixed points are orbits of the map.";
    super(app, {
      id: slot,
      title: main ? "Event map" : "Power of the map",
      help,
      slots: main ? ["map", "cobweb"] : ["power", "map"],
      export: "event_map",
    });
    this.slot = slot;
    this.main = main;
    /** Branches of one itinerary have one label, and one colour. @type {string[]} */
    this.labels = [];
    const ylabel = main ? "d_{n+1}" : "d_{n+2}";
    const plot = this.addPlot({ name: help, xlabel: "d_n", ylabel, left: main ? LEFT : undefined });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => this.paintOver();
    plot.onhover = (x, y) => this.read(x, y);
    plot.onclick = (x) => app.startAt(x);
    this.zoomable(plot);
    plot.grab = (px) =>
      main && Math.abs(px - plot.x(app.state.d)) < 5 ? (x) => app.startAt(x) : null;
  }

  /** The part with the values, the part with the orbits. */
  get values() {
    return this.answer(this.slot)?.parts.findLast((part) => part.arrays.x);
  }

  /**
   * Of the present map; until they are known those of the one before (`old`). A search completes
   * what follows from the map before.
   * @returns {{orbits: Orbit[], old: boolean, searched: boolean}}
   */
  get orbits() {
    const answer = this.answer("map");
    const now = answer?.parts.findLast((part) => part.data.orbits);
    const before = answer?.before.findLast((part) => part.data.orbits);
    const { power } = this.app.state;
    /** @type {Orbit[]} */
    const all = [...((now ?? before)?.data.orbits ?? [])];
    // Those that follow from the last map lack what only a search finds.
    const followed = now?.data.part_name === "followed";
    if (followed) all.push(...(before?.data.orbits ?? []).filter(isThrough));
    return {
      orbits: this.main ? all : all.filter(({ period }) => power % period === 0),
      old: !now,
      searched: Boolean(now) && !followed,
    };
  }

  update() {
    const { state } = this.app;
    if (!this.main) {
      this.panel.title.replaceChildren(
        "Map f",
        Object.assign(document.createElement("sup"), { textContent: String(state.power) }),
      );
      this.plot.options.ylabel = `d_{n+${state.power}}`;
    }
    const values = this.values;
    const home = values ? [...values.data.domain, ...values.data.domain] : [-1, 1, -1, 1];
    this.plot.setView(/** @type {Box} */ (state.windows[this.slot] ?? home));
    this.labels = [...new Set(values?.data.labels ?? [])];
    this.say();
  }

  say() {
    if (!this.main || !this.values) return;
    const { orbits, searched } = this.orbits;
    const proper = orbits.filter((orbit) => !isThrough(orbit));
    const stable = proper.filter((orbit) => orbit.stable).map(orbitName);
    const unstable = proper.filter((orbit) => !orbit.stable).length;
    const through = orbits.length - proper.length;
    const text =
      !searched || !orbits.length
        ? ""
        : `stable ${stable.join(", ") || "none"}; unstable ${unstable}; through a jump ${through}`;
    this.panel.say(text);
  }

  paint() {
    const { plot, values } = this;
    if (!values) return plot.message(this.emptyText(this.slot));
    const of = colors();
    plot.segment(plot.shown[0], plot.shown[0], plot.shown[1], plot.shown[1], {
      color: of.muted,
      width: 1,
    });
    for (const { at, left, right, kind } of values.data.breakpoints ?? []) {
      if (kind === "smooth") continue;
      plot.vertical(at, { color: of.muted, width: 1, dash: [2, 4], alpha: 0.55 });
      plot.segment(at, left ?? NaN, at, right ?? NaN, { color: of.muted, width: 1, dash: [3, 2] });
    }
    if (this.main) this.paintCobweb();
    this.paintBranches(values);
    this.paintOrbits();
  }

  /** @param {Part} values */
  paintBranches(values) {
    const { x, f, branch } = values.arrays;
    let from = 0;
    for (let k = 1; k <= x.length; k++) {
      if (k < x.length && branch[k] === branch[from]) continue;
      const { color, dash } = nth(this.labels.indexOf(values.data.labels[branch[from]]));
      if (branch[from] >= 0) this.plot.line(x, f, { color, dash, width: 2 }, from, k);
      from = k;
    }
  }

  paintCobweb() {
    const orbit = this.answer("cobweb")?.parts[0]?.arrays.orbit;
    if (!orbit) return;
    const [xs, ys] = [[orbit[0]], [this.plot.shown[2]]];
    for (let k = 1; k < orbit.length && Number.isFinite(orbit[k]); k++) {
      xs.push(orbit[k - 1], orbit[k]);
      ys.push(orbit[k], orbit[k]);
    }
    const late = Math.max(2, Math.floor(xs.length * 0.6));
    this.plot.line(xs, ys, { color: colors().ink, width: 0.8, alpha: 0.22 }, 0, late);
    this.plot.line(xs, ys, { color: colors().ink, width: 0.9, alpha: 0.5 }, late - 1);
  }

  paintOrbits() {
    const { plot } = this;
    const { orbits, old, searched } = this.orbits;
    const labels = new Labels(plot);
    const order = [...orbits].sort((a, b) => Number(isThrough(b)) - Number(isThrough(a)));
    const spots = order.map((orbit) => ({ orbit, at: this.spots(orbit) }));
    for (const { orbit, at } of spots) {
      plot.context.globalAlpha = old || (!searched && isThrough(orbit)) ? 0.35 : 1;
      for (const [x, y] of at) {
        const { color, size } = orbitLook(orbit);
        mark(plot, orbitShape(orbit), x, y, { color, size });
        if (isThrough(orbit)) continue;
        labels.avoid(x, y);
      }
    }
    const named = spots.filter(({ orbit }) => !isThrough(orbit));
    if (named.length <= 24) {
      for (const { orbit, at } of named)
        for (const [x, y] of at) labels.place(orbitName(orbit), x, y);
    }
    plot.context.globalAlpha = 1;
  }

  /** Where an orbit's points lie on the curve. @param {Orbit} orbit */
  spots({ points }) {
    const { power } = this.app.state;
    const shift = this.main ? 1 : power;
    return points.map((x, k) => [x, points[(k + shift) % points.length]]);
  }

  paintOver() {
    const { plot, app } = this;
    if (!this.values) return;
    const of = colors();
    plot.segment(app.state.d, plot.shown[2], app.state.d, plot.dataY(plot.bottom - 12), {
      color: of.ink,
      width: 1.5,
    });
    mark(plot, "up", app.state.d, plot.dataY(plot.bottom - 6), { size: 6 });
    const phase = this.main ? app.clock.phase() : null;
    if (!phase) return;
    if (phase.next !== null)
      plot.segment(phase.d, phase.d, phase.d, phase.next, { color: of.stick, width: 2.5 });
    mark(plot, "disc", phase.d, phase.next ?? phase.d, { color: of.stick, size: 5 });
  }

  tick() {
    if (this.main) this.plot.redrawOver();
  }

  /** @param {number} x @param {number} y */
  read(x, y) {
    const { plot, values } = this;
    if (!values) return null;
    const [px, py] = [plot.x(x), plot.y(y)];
    for (const orbit of this.orbits.orbits) {
      for (const [ax, ay] of this.spots(orbit)) {
        if (Math.hypot(plot.x(ax) - px, plot.y(ay) - py) < NEAR) return describeOrbit(orbit);
      }
    }
    const near = values.data.breakpoints?.find(
      (/** @type {any} */ b) => Math.abs(plot.x(b.at) - px) < NEAR - 3,
    );
    if (near)
      return `${near.kind} at d = ${short(near.at, 8)}: ${short(near.left)} | ${short(near.right)}\n${near.mechanism ?? ""}`;
    const { x: xs, f, branch } = values.arrays;
    const k = nearest(xs, x);
    const itinerary = values.data.itineraries?.[branch[k]];
    return `d = ${short(xs[k], 7)} → ${short(f[k], 7)}${itinerary ? `\n${itinerary}` : ""}`;
  }
}

/**
 * Infinitely unstable: through a jump. There are many, so they are marked small.
 * @param {Orbit} orbit
 */
const isThrough = ({ kind }) => kind === "infinitely unstable";

/** @param {Orbit} orbit */
function orbitLook(orbit) {
  const of = colors();
  if (isThrough(orbit)) return { color: of.purple, size: 2.5 };
  return { color: orbit.stable ? of.ink : of.vermillion, size: 4 };
}

/** @param {Orbit} orbit */
export function describeOrbit(orbit) {
  const { period, multiplier, kind, points, itinerary } = orbit;
  const lines = [`${orbitName(orbit)}: ${kind}, period ${period}`];
  if (multiplier !== null) lines.push(`multiplier ${short(multiplier, 6)}`);
  lines.push(points.map((point) => short(point, 6)).join(", "));
  if (itinerary) lines.push(itinerary.join("  |  "));
  return lines.join("\n");
}
