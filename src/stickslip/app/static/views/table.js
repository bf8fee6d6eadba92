/**
 * Orbits, breakpoints and bifurcations in a table: sorted by any column, gone to by its buttons.
 *
 * @import {App} from "../app.js"
 * @import {Thing} from "../objects.js"
 */
import { element } from "../dom.js";
import { hasLineMap } from "../model.js";
import { modeBar } from "../modes.js";
import { short } from "../numbers.js";
import { bifurcationThings, breakThings, orbitThing, orbitsOf } from "../objects.js";
import { View } from "./view.js";

/** @type {[string, (thing: Thing) => string | number][]} */
const COLUMNS = [
  ["Name", ({ name }) => name.replace(/\d+/, (digits) => digits.padStart(6, "0"))], // U2 before U10
  ["What", ({ sort, what }) => `${sort} ${what}`],
  ["Where", ({ along, at }) => (along === "d" ? at : 1e6 + at)],
  ["Multiplier", ({ factor }) => factor ?? Infinity],
  ["How", ({ why }) => why],
];

export class TableView extends View {
  /** @param {App} app */
  constructor(app) {
    const help = "Select one to go there; the arrows go just before and just after.";
    super(app, {
      id: "table",
      title: "Orbits, breaks, bifurcations",
      help,
      slots: ["map", "diagram"],
      export: "",
    });
    this.open = false;
    /** What had the focus before. @type {Element | null} */ this.from = null;
    this.sorted = { column: 1, down: true };
    this.shape = "";
    this.body = element("tbody", {
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.#walk(event),
    });
    this.heads = COLUMNS.map(([title], column) => {
      const onclick = () => this.#sort(column);
      return element("th", { scope: "col" }, element("button", { type: "button", onclick }, title));
    });
    const named = { "aria-label": "Orbits, breakpoints and bifurcations" };
    const head = element("thead", {}, element("tr", {}, ...this.heads));
    const table = element("table", named, head, this.body);
    const holder = { class: "table-holder", tabindex: "0", role: "region", ...named };
    this.panel.body.append(element("div", holder, table));
  }

  /** @override @param {any} state */
  isFor(state) {
    return this.open && hasLineMap(state);
  }

  /** @override */
  sentence() {
    const { things } = this;
    const count = (/** @type {string} */ sort) => things.filter((one) => one.sort === sort).length;
    const along = this.app.written(this.app.state.diagram.parameter);
    const known = this.hasDiagram ? count("bifurcation") : "not of these values";
    return `Orbits: ${count("orbit")}, breaks of the map: ${count("break")}, bifurcations along ${along}: ${known}. Select one to go there; the arrows go just beside it.`;
  }

  /** Whether the diagram that is known is of the present values: the map has its own state. */
  get hasDiagram() {
    return !["empty", "stale", "failed"].includes(this.app.standing("diagram").kind);
  }

  /** @returns {Thing[]} */
  get things() {
    const { app } = this;
    const orbits = orbitsOf(app).orbits.map((orbit) => orbitThing(app, orbit));
    return [...(this.hasDiagram ? bifurcationThings(app) : []), ...breakThings(app), ...orbits];
  }

  /** @param {number} column */
  #sort(column) {
    this.sorted = { column, down: this.sorted.column === column ? !this.sorted.down : true };
    this.update();
  }

  /** Up and down among the rows. @param {KeyboardEvent} event */
  #walk(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    const names = [...this.body.querySelectorAll("button.name")];
    const row = /** @type {HTMLElement} */ (event.target).closest("tr");
    const at = names.findIndex((name) => row?.contains(name));
    names[Math.min(names.length - 1, Math.max(0, at + step))]?.focus();
    event.preventDefault();
  }

  update() {
    if (!this.open) return;
    const { column, down } = this.sorted;
    const by = COLUMNS[column][1];
    const compare = (/** @type {any} */ a, /** @type {any} */ b) => (a < b ? -1 : Number(a > b));
    const things = this.things.sort((a, b) => (down ? 1 : -1) * compare(by(a), by(b)));
    const shape = JSON.stringify([column, down, things.map(({ key, why }) => key + why)]);
    if (shape === this.shape) return;
    this.shape = shape;
    const held = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset.held;
    this.heads.forEach((head, k) =>
      head.setAttribute("aria-sort", k !== column ? "none" : down ? "ascending" : "descending"),
    );
    this.body.replaceChildren(...things.map((thing) => this.#row(thing)));
    if (held) this.body.querySelector(`[data-held="${CSS.escape(held)}"]`)?.focus();
  }

  /** @param {Thing} thing */
  #row(thing) {
    const { key, sort, name, what, at, factor, why, modes } = thing;
    const along = this.app.written(thing.along);
    const place = `${name} at ${along} = ${short(at, 8)}`;
    const [before, there, after] = [-1, 0, 1].map((side) => {
      const label = `${["Just before", "Go to", "Just after"][side + 1]} ${place}`;
      const named = { "aria-label": label, title: label, "data-held": key + side };
      const look = { type: "button", class: side ? "beside" : "name", ...named };
      return element(
        "button",
        { ...look, onclick: () => thing.go(side) },
        ["◂", name, "▸"][side + 1],
      );
    });
    const cells = [
      [there, before, after],
      [sort === "orbit" ? `orbit, ${what}` : what],
      [`${along} = ${short(at, 10)}`],
      [factor === null ? "" : short(factor, 6)],
      [...modes.map(modeBar), why],
    ];
    return element("tr", {}, ...cells.map((content) => element("td", {}, ...content)));
  }
}
