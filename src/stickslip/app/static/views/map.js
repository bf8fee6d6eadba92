/**
 * The event map, or a power of it: branches, breakpoints, orbits, cobweb.
 *
 * @import {App} from "../app.js"
 * @import {Orbit, Part, State, Box} from "../types.js"
 */
import { Labels, mark, orbitShape } from "../marks.js";
import { coordinateOf, startPoint, sticksAsOne, windowOf } from "../model.js";
import { modeBar } from "../modes.js";
import { AWAY, breakThings, isThrough, orbitThing, orbitsOf, told, under } from "../objects.js";
import { colorOf, colors } from "../theme.js";
import { listed, nearest, short } from "../numbers.js";
import { OUTSIDE, View, framed } from "./view.js";

const LEFT = 58;
const GESTURES = "Click to start a motion, drag to zoom.";
const HELP = `From one global stick phase to the next: d = X₂ − X₁. ${GESTURES}`;
const HELP_OF_RETURNS = `From one return of the motion to the next. ${GESTURES}`;

export class MapView extends View {
  /** @param {App} app @param {"map" | "power"} slot */
  constructor(app, slot) {
    const main = slot === "map";
    const help = main
      ? HELP
      : "The map applied several times: its fixed points are orbits of the map.";
    super(app, {
      id: slot,
      title: main ? "Event map" : "Power of the map",
      help,
      slots: main ? ["map", "cobweb"] : ["power", "map"],
      export: "event_map",
    });
    this.slot = slot;
    this.main = main;
    const ylabel = main ? "d_{n+1}" : "d_{n+2}";
    const look = main ? { left: LEFT, square: true } : {};
    const plot = this.addPlot({ name: help, xlabel: "d_n", ylabel, ...look });
    this.plot = plot;
    plot.paint = () => this.paint();
    plot.paintOver = () => this.paintOver();
    plot.onhover = (x, y) => this.read(x, y);
    plot.onclick = (x, y) => (this.thing(x, y)?.go ?? (() => app.startAt(x)))(0);
    this.zoomable(plot);
    plot.grab = (px) =>
      main && Math.abs(px - plot.x(startPoint(app.state))) < 5 ? (x) => app.startAt(x) : null;
  }

  /** Of the map its power shows the orbits alone, or that there are none. @override @param {string} slot @param {Part} [part] */
  shows(slot, part) {
    const all = slot === this.slots[0] || this.main || !part;
    return super.shows(slot) && (all || "orbits" in part.data || part.last);
  }

  /** Orbits of the power. @override */
  get extra() {
    const { power, max_period } = this.app.state;
    return this.main ? {} : { max_period: Math.min(power, max_period) };
  }

  /** @override */
  get frame() {
    return framed(windowOf(this.app.state, this.slot));
  }

  /** The part with the values, the part with the orbits. */
  get values() {
    return this.answer(this.slot)?.parts.findLast((part) => part.arrays.x);
  }

  /** Those of the map; of its power those that are its fixed points, if the map is of the same values. */
  get orbits() {
    const known = orbitsOf(this.app);
    const { power } = this.app.state;
    if (this.main) return known;
    const orbits = known.orbits.filter(({ period }) => !known.past && power % period === 0);
    return { ...known, orbits, old: known.old || known.past };
  }

  update() {
    const { state } = this.app;
    const name = coordinateOf(state);
    const after = (/** @type {string} */ step) => name.replace(/_?(\d*)$/, (_, k) => `_{${k && `${k},`}${step}}`);
    const ofBlocks = sticksAsOne(state.model);
    Object.assign(this.plot.options, { xlabel: after("n"), ylabel: after("n+1") });
    if (this.main) {
      this.panel.name(ofBlocks ? "Event map" : "Return map");
      this.help(ofBlocks ? HELP : HELP_OF_RETURNS);
    } else {
      this.panel.name("Map f", state.power);
      this.plot.options.ylabel = after(`n+${state.power}`);
    }
    const values = this.values;
    const home = values ? [...values.data.domain, ...values.data.domain] : [-1, 1, -1, 1];
    this.plot.setView(/** @type {Box} */ (windowOf(state, this.slot) ?? home), startPoint(state));
  }

  sentence() {
    const { values } = this;
    if (!values) return "";
    const ofBlocks = sticksAsOne(this.app.state.model);
    const name = this.app.written("d");
    if (!values.arrays.branch.some((/** @type {number} */ branch) => branch >= 0))
      return ofBlocks
        ? "No value: from no d shown do both blocks stick together again."
        : `No value: from no point shown does the motion return${this.main ? "" : " so often in the domain"}.`;
    const { state } = this.app;
    const { power } = state;
    const d = startPoint(state);
    const shown = this.plot.view; // what is drawn by now may be of the view before
    const isSeen = (/** @type {number} */ y) => y >= shown[2] && y <= shown[3];
    const off = values.arrays.f.some(isSeen) ? "" : OUTSIDE;
    const all = this.orbits.orbits.filter((orbit) => !isThrough(orbit));
    const proper = all.filter((orbit) =>
      this.spots(orbit).some(
        ([x, y]) => x >= shown[0] && x <= shown[1] && y >= shown[2] && y <= shown[3],
      ),
    );
    const stable = proper.filter((orbit) => orbit.stable).map(({ name }) => name);
    const open = proper.length - stable.length;
    const settles = stable.length
      ? `${listed(stable)} attract${stable.length > 1 ? "" : "s"}`
      : `no orbit${this.orbits.complete ? "" : " seen"} attracts`;
    const counted = proper.length ? `${settles}, ${open || "none"} repel${open === 1 ? "s" : ""}` : "";
    const beyond = all.length - proper.length;
    const elsewhere = beyond ? `${counted ? "; " : "no orbit, "}${beyond} outside` : "";
    const here = windowOf(state, this.slot) && all.length ? "in this window " : "";
    const none = this.orbits.old ? "." : ": no orbit is known.";
    const known = counted || elsewhere ? `: ${here}${counted}${elsewhere}.` : none;
    const more = this.orbits.complete ? "" : " Others may lie between the samples.";
    const steps = `${power} ${ofBlocks ? "stick" : "return"}${power > 1 ? "s" : ""}`;
    if (!this.main) return `Repeating after ${steps}${known}${off}${more}`;
    const breaks = breakThings(this.app).filter(({ of }) => of.kind !== "smooth");
    const seen = breaks.filter(({ at }) => at >= shown[0] && at <= shown[1]);
    const [near] = (seen.length ? seen : breaks).sort((a, b) => Math.abs(a.at - d) - Math.abs(b.at - d));
    const where = near && `${near.name} ${near.at < d ? "left" : "right"} of ${name} = ${short(d, 4)}`;
    const isBeyond = near && (near.at < d ? near.of.right : near.of.left) === null; // d, where no value is
    const why = near?.why && `: ${near.why.split(AWAY)[0].replace("beyond", isBeyond ? "before it" : "beyond")}`;
    const nearest = near ? ` Nearest ${where}, at ${short(near.at, 4)}${why}.` : "";
    const each = ofBlocks ? "Each stick of both blocks" : `Each ${releaseOf(this.app.state)}`;
    return `${each}, at ${name}, leads to the next, at f(${name})${known}${off}${more}${nearest}`;
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
    this.paintOrbits(values);
  }

  /** @param {Part} values */
  paintBranches(values) {
    const { x, f, branch } = values.arrays;
    let from = 0;
    for (let k = 1; k <= x.length; k++) {
      if (k < x.length && branch[k] === branch[from]) continue;
      if (branch[from] >= 0)
        this.plot.line(x, f, { color: this.color(values, branch[from]), width: 2 }, from, k);
      from = k;
    }
  }

  /** Branches of one itinerary have one colour. @param {Part} values @param {number} branch */
  color({ data: { itineraries, labels } }, branch) {
    return colorOf((this.main && itineraries?.[branch]) || labels[branch]);
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

  /** @param {Part} values */
  paintOrbits(values) {
    const { plot } = this;
    const { orbits, old, searched } = this.orbits;
    const labels = new Labels(plot);
    labels.avoidLine(values.arrays.x, values.arrays.f);
    const order = [...orbits].sort((a, b) => Number(isThrough(b)) - Number(isThrough(a)));
    const spots = order.map((orbit) => ({ orbit, at: this.spots(orbit) }));
    const named = spots.filter(({ orbit }) => !isThrough(orbit));
    const few = named.length <= 24; // of more marks at full size would cover the map
    for (const { orbit, at } of spots) {
      plot.context.globalAlpha = old || (!searched && isThrough(orbit)) ? 0.35 : 1;
      for (const [x, y] of at) {
        const { color, size } = orbitLook(orbit);
        mark(plot, orbitShape(orbit), x, y, { color, size: few || orbit.stable ? size : size / 2 });
        if (isThrough(orbit)) continue;
        labels.avoid(x, y);
      }
    }
    if (few) {
      for (const { orbit, at } of named)
        for (const [x, y] of at) labels.place(orbit.name, x, y);
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
    const d = startPoint(app.state);
    plot.segment(d, plot.shown[2], d, plot.dataY(plot.bottom - 12), {
      color: of.ink,
      width: 1.5,
    });
    mark(plot, "up", d, plot.dataY(plot.bottom - 6), { size: 6 });
    const phase = this.main ? app.clock.phase() : null;
    if (!phase) return;
    if (phase.next !== null)
      plot.segment(phase.d, phase.d, phase.d, phase.next, { color: of.stick, width: 2.5 });
    mark(plot, "disc", phase.d, phase.next ?? phase.d, { color: of.stick, size: 5 });
  }

  tick() {
    if (this.main) this.plot.redrawOver();
  }

  /** What is marked there. @param {number} x @param {number} y */
  thing(x, y) {
    const { app } = this;
    const orbits = this.orbits.orbits.map((orbit) => ({
      thing: orbitThing(app, orbit),
      spots: this.spots(orbit),
    }));
    const breaks = this.main
      ? breakThings(app).map((thing) => ({ thing, spots: [[thing.at, NaN]] }))
      : [];
    return under(this.plot, x, y, [...orbits, ...breaks]);
  }

  /** @param {number} x @param {number} y @returns {import("../plot.js").Tip} */
  read(x, y) {
    const { values } = this;
    if (!values) return null;
    const thing = this.thing(x, y);
    if (thing) return told(thing);
    const { x: xs, f, branch } = values.arrays;
    const k = nearest(xs, x);
    const itinerary = values.data.itineraries?.[branch[k]];
    const name = this.app.written("d");
    const text = `${name} = ${short(xs[k], 7)} → ${short(f[k], 7)}${itinerary ? "\n" : ""}`;
    return itinerary ? [text, modeBar(itinerary)] : text;
  }
}

/** What a return map goes from and to. @param {State} state */
const releaseOf = ({ section }) =>
  section?.event === "landing" ? "landing, the end of a slip" : "release, the end of a stick";

/** Those through a jump are many, and marked small. @param {Orbit} orbit */
function orbitLook(orbit) {
  const of = colors();
  if (isThrough(orbit)) return { color: of.purple, size: 2.5 };
  return { color: orbit.stable ? of.ink : of.vermillion, size: 4 };
}
