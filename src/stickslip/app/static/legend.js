/** What letters, marks, lines and colours mean: one table, from which the dialog is made. */
import { element, openDialog } from "./dom.js";
import { BIFURCATIONS, mark } from "./marks.js";
import { modeBar } from "./modes.js";
import { colors } from "./theme.js";

/** Under a heading: sample (a mark, a line, bars or none), name, words. @type {Record<string, string[][]>} */
const GROUPS = {
  "Orbits: motions that repeat": [
    ["mark disc ink", "S4", "stable: motions nearby settle on it; repeats after 4 common sticks"],
    ["mark square vermillion", "U1", "unstable: motions nearby leave it; numbered by periods, then from left to right"],
    ["mark cross purple", "", "infinitely unstable: through a jump of the map"],
  ],
  "Event map": [
    ["line blue 2", "", "a branch; an order of sticks and slips keeps its colour, neighbours differ"],
    ["line muted 1 2,4", "", "a break between branches; dashes span a jump"],
    ["line ink 0.9", "", "the staircase: the motion from the marked d, stick after stick"],
    ["bars -. -- ..", "", "an order of sticks (bars) and slips (arrows), a row for each block"],
  ],
  "Bifurcation diagram": [
    ["line ink 2.4", "", "thick: stable orbit"],
    ["line vermillion 1", "", "thin: unstable orbit"],
    ["line purple 1 5,2", "", "dashed: infinitely unstable orbit, through a jump"],
    ["line muted 1 6,4", "", "grey, dashed: a break of the map"],
    ["line blue 3 2,2", "", "dots: where motions settle"],
    ...Object.entries(BIFURCATIONS).map(([short, [shape, color, words]]) => [
      `mark ${shape} ${color}`,
      short,
      words,
    ]),
  ],
  "Blocks and views": [
    ["line stick 7", "", "rides on the belt"],
    ["line slip 2", "", "slips"],
    ["", "shipped answer", "computed before; gives way to what your machine computes"],
    ["", "incomplete", "of the values set now, but for what could not be decided: the button lists it"],
    ["", "older values", "dimmed: not of the values set now; the reason stands beside it"],
    ["", "failed", "dimmed: nothing could be computed with these values"],
  ],
};

/** Opens the legend. */
export function showLegend() {
  const groups = Object.entries(GROUPS).flatMap(([title, rows]) => [
    element("h3", {}, title),
    element("dl", {}, ...rows.map(line)),
  ]);
  openDialog("What the marks mean", "help legend", ...groups);
}

/** @param {string[]} row */
function line([sample, name, words]) {
  return element(
    "div",
    {},
    element("dt", {}, sample && drawn(sample), name),
    element("dd", {}, words),
  );
}

/** @param {string} sample */
function drawn(sample) {
  const [kind, first, second, dash = ""] = sample.split(" ");
  if (kind === "bars") return modeBar(sample.slice(5));
  const canvas = element("canvas", { width: 72, height: 36, "aria-hidden": "true" });
  const context = canvas.getContext("2d");
  context.scale(2, 2);
  const self = (/** @type {number} */ pixels) => pixels;
  const plot = /** @type {any} */ ({ context, x: self, y: self });
  const shape = /** @type {import("./marks.js").Shape} */ (first);
  if (kind === "mark") mark(plot, shape, 18, 9, { color: colors()[second], size: 5 });
  else {
    context.strokeStyle = colors()[first];
    context.lineWidth = Number(second);
    context.setLineDash(dash.split(",").map(Number));
    context.stroke(new Path2D("M2 9H34"));
  }
  return canvas;
}
