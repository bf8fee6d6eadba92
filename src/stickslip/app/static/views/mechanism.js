/**
 * The blocks on their belt, moving; below, who sticks when.
 *
 * @import {App} from "../app.js"
 * @import {Plot} from "../plot.js"
 */
import { element } from "../dom.js";
import { listed } from "../numbers.js";
import { mathText } from "../plot.js";
import { SANS, colors } from "../theme.js";
import { Timeline } from "./motion.js";
import { View } from "./view.js";

const BELT = 18; // height of the belt, pixels

export class MechanismView extends View {
  /** @param {App} app */
  constructor(app) {
    const help = "The blocks on their belt. Filled: rides with the belt; outlined: slips.";
    super(app, {
      id: "mechanism",
      title: "Mechanism",
      help,
      slots: ["motion"],
      export: "mechanism",
    });
    const plot = this.addPlot({ name: help, xlabel: "", ylabel: "", empty: true });
    this.plot = plot;
    plot.paintOver = () => this.paint();
    const host = element("div", { class: "timeline" });
    this.panel.body.append(host);
    this.timeline = new Timeline(app, host);
    this.plots.push(this.timeline.plot);
  }

  update() {
    const { arrays } = this.app.clock;
    if (arrays && arrays !== this.of) {
      this.of = arrays;
      this.reach = arrays.x.reduce(
        (/** @type {number} */ most, /** @type {number} */ x) => Math.max(most, Math.abs(x)),
        0.1,
      );
    }
    this.timeline.update();
    this.plot.redrawOver();
  }

  /** @override */
  sentence() {
    const { clock } = this.app;
    const k = clock.index();
    const data = clock.motion?.parts[0]?.data;
    if (k < 0 || !data) return "";
    const count = data.limits.length;
    const doing = ["riding on the belt", "slipping forward", "slipping back"];
    const blocks = Array.from({ length: count }, (_, b) => doing[clock.arrays.mode[k * count + b]]);
    const same = count > 1 && blocks.every((one) => one === blocks[0]);
    const text = same
      ? `Now ${count === 2 ? "both" : "all"} blocks are ${blocks[0]}.`
      : `Now ${listed(blocks.map((one, b) => `block ${b + 1} is ${one}`))}.`;
    return data.status ? `${text} ${data.message}` : text;
  }

  tick() {
    this.panel.say(this.sentence());
    this.plot.redrawOver();
    this.timeline.plot.redrawOver();
    const { clock } = this.app;
    this.app.showTime(clock.t);
  }

  /** Where things stand, in pixels. @param {number} count */
  layout(count) {
    const { width = 0, height = 0 } = this.plot;
    const spacing = (width - 40) / (count + 0.6);
    const floor = height - BELT - 5;
    const side = Math.min(0.62 * floor, 0.36 * spacing, 62);
    const unit = Math.min(0.5 * (spacing - 1.3 * side), 90) / (this.reach ?? 1);
    return {
      width,
      floor,
      side,
      wide: 1.3 * side,
      unit,
      rest: (/** @type {number} */ k) => 20 + spacing * (k + 0.8),
    };
  }

  paint() {
    const k = this.app.clock.index();
    const { arrays } = this.app.clock;
    if (k < 0 || arrays !== this.of) return;
    const count = arrays.x.length / arrays.t.length;
    const at = this.layout(count);
    const V = this.answer("motion")?.parts[0]?.data.V ?? 0;
    this.#belt(at, V * this.app.clock.t * at.unit, V);
    this.#walls(at);
    const x = Array.from(
      { length: count },
      (_, b) => at.rest(b) + at.unit * arrays.x[k * count + b],
    );
    const { model } = this.app.state;
    const stiff =
      model.kind === "oscillator"
        ? [1]
        : [1, ...Array(count - 1).fill([model.alpha ?? 1].flat()[0]), 1];
    const ends = [8, ...x.flatMap((c) => [c - at.wide / 2, c + at.wide / 2]), at.width - 8];
    stiff.forEach((stiffness, j) => {
      if (stiffness > 0)
        this.#spring(ends[2 * j], ends[2 * j + 1], at.floor - 0.62 * at.side, stiffness);
    });
    x.forEach((centre, b) =>
      this.#block(at, b, centre, arrays.mode[k * count + b] === 0, arrays.v[k * count + b] - V),
    );
  }

  /** @param {any} at @param {number} shift @param {number} V */
  #belt({ width, floor }, shift, V) {
    const c = this.plot.context;
    const of = colors();
    const [left, right, r] = [22, width - 22, BELT / 2];
    c.lineWidth = 1.5;
    c.strokeStyle = of.ink;
    c.beginPath();
    c.roundRect(left, floor, right - left, BELT, r);
    c.stroke();
    c.lineWidth = 1;
    c.strokeStyle = of.muted;
    c.beginPath();
    for (let x = left + r + (shift % 24); x < right - r; x += 24) {
      c.moveTo(x, floor + 1.5);
      c.lineTo(x - 4, floor + 6);
    }
    c.stroke();
    for (const centre of [left + r, right - r]) {
      c.beginPath();
      c.arc(centre, floor + r, r - 3.5, 0, 7);
      c.moveTo(centre, floor + r);
      c.lineTo(
        centre + (r - 3.5) * Math.cos(shift / r),
        floor + r + (r - 3.5) * Math.sin(shift / r),
      );
      c.stroke();
    }
    const middle = width / 2;
    arrow(c, middle - 16, floor + r + 3, middle + 16, of.ink);
    mathText(c, "V", middle + 26, floor + r + 7, of.ink);
  }

  /** @param {any} at */
  #walls({ width, floor }) {
    const c = this.plot.context;
    c.lineWidth = 1;
    c.strokeStyle = colors().ink;
    c.beginPath();
    for (const [wall, out] of [
      [8, -1],
      [width - 8, 1],
    ]) {
      c.moveTo(wall, 6);
      c.lineTo(wall, floor + 4);
      for (let y = 10; y < floor + 4; y += 7) {
        c.moveTo(wall, y);
        c.lineTo(wall + 6 * out, y + 5);
      }
    }
    c.stroke();
  }

  /** @param {number} from @param {number} to @param {number} y @param {number} stiffness */
  #spring(from, to, y, stiffness) {
    const c = this.plot.context;
    const turns = 8;
    const lead = Math.min(12, 0.12 * (to - from));
    const step = (to - from - 2 * lead) / (2 * turns);
    c.beginPath();
    c.moveTo(from, y);
    c.lineTo(from + lead, y);
    for (let k = 0; k < 2 * turns; k++)
      c.lineTo(from + lead + (k + 0.5) * step, y + (k % 2 ? 5 : -5));
    c.lineTo(to - lead, y);
    c.lineTo(to, y);
    c.lineWidth = Math.min(2.4, 1.1 * Math.sqrt(stiffness));
    c.strokeStyle = colors().muted;
    c.lineJoin = "round";
    c.stroke();
  }

  /**
   * @param {any} at
   * @param {number} block
   * @param {number} centre
   * @param {boolean} rides
   * @param {number} w
   */
  #block({ floor, side, wide }, block, centre, rides, w) {
    const c = this.plot.context;
    const of = colors();
    const left = centre - wide / 2;
    c.beginPath();
    c.roundRect(left, floor - side, wide, side, 3);
    c.fillStyle = rides ? of.stick : of.panel;
    c.fill();
    c.lineWidth = 2;
    c.strokeStyle = rides ? of.stick : of.slip;
    c.setLineDash(rides ? [] : [6, 3]);
    c.stroke();
    c.setLineDash([]);
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.font = `600 13px ${SANS}`;
    c.fillStyle = rides ? of.panel : of.ink;
    c.fillText(String(block + 1), centre, floor - 0.66 * side);
    c.font = `11px ${SANS}`;
    c.fillText(rides ? "stick" : "slip", centre, floor - 0.3 * side);
    if (!rides)
      arrow(
        c,
        centre,
        floor - side - 7,
        centre + Math.sign(w) * Math.min(30, 10 + 40 * Math.abs(w)),
        of.slip,
      );
  }
}

/**
 * @param {CanvasRenderingContext2D} c
 * @param {number} x0
 * @param {number} y
 * @param {number} x1
 * @param {string} color
 */
function arrow(c, x0, y, x1, color) {
  const tip = Math.sign(x1 - x0) * 6;
  c.strokeStyle = c.fillStyle = color;
  c.lineWidth = 1.5;
  c.beginPath();
  c.moveTo(x0, y);
  c.lineTo(x1 - tip, y);
  c.stroke();
  c.beginPath();
  c.moveTo(x1, y);
  c.lineTo(x1 - tip, y - 3.5);
  c.lineTo(x1 - tip, y + 3.5);
  c.fill();
}
