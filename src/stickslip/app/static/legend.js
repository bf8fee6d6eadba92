/** What letters, marks, lines and colours mean: one table, from which the dialog is made. */
import { element } from "./dom.js";
import { BIFURCATIONS, mark } from "./marks.js";
import { modeBar } from "./modes.js";
import { colors, nth } from "./theme.js";

/** @typedef {(c: CanvasRenderingContext2D, plot: any) => void} Draw */

/** @type {(shape: any, color?: string, size?: number) => Draw} */
const spot = (shape, color = "ink", size = 5) => (_, plot) => mark(plot, shape, 18, 9, { color: colors()[color], size });

/** @type {(look: {color?: string, width?: number, dash?: number[]}) => Draw} */
const stroke = ({ color = "ink", width = 2, dash = [] }) => (c) => {
  c.strokeStyle = colors()[color] ?? color;
  c.lineWidth = width;
  c.setLineDash(dash);
  c.beginPath();
  c.moveTo(2, 9);
  c.lineTo(34, 9);
  c.stroke();
};

/** @returns {[string, [Draw | string, string, string][]][]} */
const groups = () => [
  [
    "Orbits: motions that repeat",
    [
      [spot("disc"), "S4", "stable: motions nearby settle on it; it repeats after 4 sticks of both blocks"],
      [spot("square", "vermillion"), "U1", "unstable: motions nearby leave it"],
      [spot("cross", "purple", 3), "", "infinitely unstable: through a jump of the map"],
    ],
  ],
  [
    "Event map",
    [
      [stroke({ color: nth(0).color }), "", "a branch; one colour for one order of sticks and slips"],
      [stroke({ color: nth(0).color, dash: [7, 3] }), "", "dashed: colours are used up, another order"],
      [stroke({ color: "muted", dash: [2, 4], width: 1 }), "", "a break between branches; a jump where two dashed ends part"],
      [stroke({ width: 0.9 }), "", "the staircase: the motion from the marked d, stick after stick"],
      ["-. -- ..", "", "an order of sticks (bars) and slips (arrows), a row for each block, in tips and in the table"],
    ],
  ],
  [
    "Bifurcation diagram",
    [
      [stroke({ width: 2.4 }), "", "thick: stable orbit"],
      [stroke({ color: "vermillion", width: 1 }), "", "thin: unstable orbit"],
      [stroke({ color: "muted", dash: [6, 4], width: 1 }), "", "dashed: a break of the map"],
      [stroke({ color: "blue", width: 3, dash: [2, 2] }), "", "dots: where motions settle"],
      ...Object.entries(BIFURCATIONS).map(
        ([short, [shape, color, words]]) => /** @type {[Draw, string, string]} */ ([spot(shape, color), short, words]),
      ),
    ],
  ],
  [
    "Blocks and views",
    [
      [stroke({ color: "stick", width: 7 }), "", "rides on the belt"],
      [stroke({ color: "slip", width: 2 }), "", "slips"],
      ["", "shipped answer", "computed before, with the package; gives way to what your machine computes"],
      ["", "older values", "dimmed: not of the values set now; the reason stands beside it"],
      ["", "failed", "dimmed: nothing could be computed with these values"],
    ],
  ],
];

/** Opens the legend. */
export function showLegend() {
  const close = element("button", { type: "button", class: "close", onclick: () => dialog.close() }, "Close");
  const dialog = element(
    "dialog",
    { class: "help legend", "aria-labelledby": "legend-title", onclose: () => dialog.remove() },
    element("h2", { id: "legend-title" }, "What the marks mean"),
    ...groups().map(([title, rows]) =>
      element("section", {}, element("h3", {}, title), element("dl", {}, ...rows.map((row) => line(...row)))),
    ),
    close,
  );
  document.body.append(dialog);
  dialog.showModal();
}

/** @param {Draw | string} sample @param {string} name @param {string} words */
function line(sample, name, words) {
  const drawn = typeof sample === "function" ? canvasOf(sample) : sample ? modeBar(sample) : "";
  return element("div", {}, element("dt", {}, drawn, name), element("dd", {}, words));
}

/** @param {Draw} draw */
function canvasOf(draw) {
  const canvas = element("canvas", { width: 72, height: 36, "aria-hidden": "true" });
  const context = canvas.getContext("2d");
  context.scale(2, 2);
  draw(context, { context, x: (/** @type {number} */ v) => v, y: (/** @type {number} */ v) => v });
  return canvas;
}
