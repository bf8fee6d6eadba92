/**
 * Limit cycles of models whose events make no map of an interval: a table.
 *
 * @import {App} from "../app.js"
 */
import { element } from "../dom.js";
import { inWordsOf, mapOf, sticksAsOne, whatRubs } from "../model.js";
import { listed, short, spelled } from "../numbers.js";
import { View } from "./view.js";

const UNSTABLE = "unstable"; // found by Newton's method: no motion ends there

export class CycleView extends View {
  /** @param {App} app */
  constructor(app) {
    const help = "Period and Floquet multipliers of the cycle that the motion comes to.";
    super(app, { id: "cycle", title: "Limit cycle", help, slots: ["cycle"], export: "cycle" });
    this.table = element("div", {
      class: "table-holder",
      tabindex: "0",
      role: "region",
      "aria-label": "Period and multipliers",
    });
    this.panel.body.append(this.table);
  }

  /** @override */
  sentence() {
    const cycle = this.answer("cycle")?.parts[0]?.data;
    if (cycle?.why) return "From this start no cycle is reached.";
    if (!cycle) return "";
    const how = stability(cycle);
    const reached = how === UNSTABLE ? "Near the motion is" : "The motion ends on";
    return `${reached} a cycle that repeats every ${short(cycle.period, 4)}: ${how}.`;
  }

  update() {
    const answer = this.answer("cycle");
    const cycle = answer?.parts[0]?.data;
    const { model } = this.app.state;
    const { kind, why, coordinates } = mapOf(this.app.state);
    const none = inWordsOf(model, `none. ${why.charAt(0).toUpperCase()}${why.slice(1)}`);
    const has = `has ${coordinates.length} numbers, ${listed(coordinates)}: see Basins`;
    const map = kind === "unknown" ? [] : [["return map", kind === "space" ? has : none]];
    const ours = sticksAsOne(model) ? [] : map;
    if (cycle?.why)
      return this.table.replaceChildren(rowsOf([["cycle", inWordsOf(model, cycle.why)], ...ours]));
    if (!cycle) return this.table.replaceChildren(rowsOf([["cycle", this.emptyText("cycle")], ...ours]));
    const what = whatRubs(model);
    const lines = [
      ["period", short(cycle.period, 10)],
      ["stability", stability(cycle)],
      ["multipliers", cycle.multipliers.map(complex).join(", ") || "none"],
      ["closes to", short(cycle.residual, 3)],
      [
        "events",
        cycle.events.map((/** @type {any} */ { block, kind }) => `${what} ${block}: ${kind}`).join(", "),
      ],
      ...ours,
    ];
    this.table.replaceChildren(rowsOf(lines));
  }
}

/** In words: a multiplier of size 1 tells neither. @param {any} cycle */
function stability({ stable, multipliers }) {
  if (stable) return "stable";
  const sizes = multipliers.map((/** @type {any} */ one) => Math.hypot(...[one].flat()));
  const neutral = short(Math.max(...sizes), 6) === "1";
  return neutral ? "neither stable nor unstable, a multiplier has size 1" : UNSTABLE;
}

/** A table of names and what is said of them. @param {string[][]} lines */
function rowsOf(lines) {
  const rows = lines.map(([name, value]) =>
    element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, spelled(value))),
  );
  return element("table", {}, element("tbody", {}, ...rows));
}

/** A number that stays on one line. @param {[number, number] | number} value */
function complex(value) {
  const [re, im] = [value].flat();
  if (!im) return short(re, 6);
  return [short(re, 5), im < 0 ? "−" : "+", short(Math.abs(im), 5), "i"].join("\u00a0");
}
