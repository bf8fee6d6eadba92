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
  ["Name", ({ name }) => name],
  ["What", ({ sort, what }) => `${sort} ${what}`],
  ["Where", ({ along, at }) => (along === "d" ? at : 1e6 + at)],
  ["Multiplier", ({ factor }) => factor ?? Infinity],
  ["How", ({ why }) => why],
];

export class TableView extends View {
  /** @param {App} app */
  constructor(app) {
    const help = "Select one to go there; the arrows go just before and just after.";
    super(app, { id: "table", title: "Orbits, breaks, bifurcations", help, slots: ["map", "diagram"], export: "" });
    this.open = false;
    this.sorted = { column: 1, down: true };
    this.shape = "";
    this.body = element("tbody", { onkeydown: (/** @type {KeyboardEvent} */ event) => this.#walk(event) });
    this.heads = COLUMNS.map(([title], column) =>
      element("th", { scope: "col" }, element("button", { type: "button", onclick: () => this.#sort(column) }, title)),
    );
    const label = "Orbits, breakpoints and bifurcations";
    this.panel.body.append(
      element(
        "div",
        { class: "table-holder", tabindex: "0", role: "region", "aria-label": label },
        element("table", { "aria-label": label }, element("thead", {}, element("tr", {}, ...this.heads)), this.body),
      ),
    );
  }

  /** @override @param {any} state */
  isFor(state) {
    return this.open && hasLineMap(state.model);
  }

  /** @override */
  sentence() {
    const { things } = this;
    const count = (/** @type {string} */ sort) => things.filter((one) => one.sort === sort).length;
    return `${count("orbit")} orbits, ${count("break")} breaks of the map, ${count("bifurcation")} bifurcations along ${this.app.state.diagram.parameter}. Select one to go there.`;
  }

  /** @returns {Thing[]} */
  get things() {
    const { app } = this;
    const orbits = orbitsOf(app).orbits.map((orbit) => orbitThing(app, orbit));
    return [...bifurcationThings(app), ...breakThings(app), ...orbits];
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
    this.heads.forEach((head, k) => head.setAttribute("aria-sort", k !== column ? "none" : down ? "ascending" : "descending"));
    this.body.replaceChildren(...things.map((thing) => this.#row(thing)));
    if (held) this.body.querySelector(`[data-held="${CSS.escape(held)}"]`)?.focus();
  }

  /** @param {Thing} thing */
  #row(thing) {
    const { key, sort, name, what, along, at, factor, why, modes } = thing;
    const button = (/** @type {string} */ text, /** @type {string} */ label, /** @type {number} */ side, kind = "beside") =>
      element("button", { type: "button", class: kind, "aria-label": label, title: label, "data-held": key + side, onclick: () => thing.go(side) }, text);
    const place = `${name} at ${along} = ${short(at, 8)}`;
    const cells = [
      [button(name, `Go to ${place}`, 0, "name"), button("◂", `Just before ${place}`, -1), button("▸", `Just after ${place}`, 1)],
      [sort === "break" ? what : `${sort === "orbit" ? "orbit, " : ""}${what}`],
      [`${this.app.symbol(along).replace(/_\{?\w+\}?/, "")} = ${short(at, 10)}`],
      [factor === null ? "" : short(factor, 6)],
      [...modes.map(modeBar), why],
    ];
    return element("tr", {}, ...cells.map((content) => element("td", {}, ...content)));
  }
}
