/**
 * Bodies, springs and what they rub on, moving; below, which contact sticks when.
 *
 * @import {App} from "../app.js"
 * @import {Plot} from "../plot.js"
 */
import { element } from "../dom.js";
import { isStructure, whatRubs } from "../model.js";
import { column, listed, short, span } from "../numbers.js";
import { mathText } from "../plot.js";
import { SANS, colors } from "../theme.js";
import { contactName, Timeline } from "./motion.js";
import { View } from "./view.js";

const PICTURES = ["svg", "png", "gif", "mp4"];
const BELT = 18; // height of the belt, pixels
const RAISED = 16; // a body that does not rub itself, above the floor
const MOST_NAMED = 4; // contacts of which a sentence says one by one what they do

export class MechanismView extends View {
  /** @param {App} app */
  constructor(app) {
    const help = "What moves and what it rubs on. Filled: sticks; outlined: slips.";
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
      // The server draws blocks on one belt, of which the contacts' displacements are the blocks' own.
      this.panel.offer((format) => arrays.u === arrays.x || !PICTURES.includes(format));
      this.scene = sceneOf(this.app.clock.model, this.app.clock.motion?.parts[0]?.data, arrays);
      this.plot.redrawOver();
    }
    this.timeline.update();
  }

  /** @override */
  sentence() {
    const { clock } = this.app;
    const k = clock.index();
    const data = clock.motion?.parts[0]?.data;
    if (k < 0 || !data) return "";
    const { contacts } = data;
    const rides = (/** @type {any} */ { V }) => (V ? "riding on the belt" : "sticking");
    const doing = contacts.map(
      (/** @type {any} */ contact, /** @type {number} */ c) =>
        [rides(contact), "slipping forward", "slipping back"][
          clock.arrays.mode[k * contacts.length + c]
        ],
    );
    const names = contacts.map((/** @type {any} */ contact, /** @type {number} */ c) =>
      contactName(clock.model, contact, c).toLowerCase(),
    );
    const same = doing.length > 1 && doing.every((/** @type {string} */ one) => one === doing[0]);
    const all = `${whatRubs(clock.model)}s`;
    const each = doing.map((/** @type {string} */ one, /** @type {number} */ c) => `${names[c]} is ${one}`);
    const groups = [...new Set(doing)].map((one) => {
      const n = doing.filter((/** @type {string} */ other) => other === one).length;
      return `${n} ${n === 1 ? "is" : "are"} ${one}`;
    });
    const now = same
      ? `${doing.length === 2 ? "both" : "all"} ${all} are ${doing[0]}`
      : doing.length > MOST_NAMED
        ? `of ${doing.length} ${all} ${listed(groups)}`
        : listed(each);
    const drawn = data.bodies ? "" : " Drawn is what rubs, not what it hangs on.";
    const ends = data.status ? ` It is followed to t = ${short(data.t_end, 4)}: ${data.message}.` : "";
    return `Now ${now}.${drawn}${ends}`;
  }

  tick() {
    this.panel.say(this.sentence());
    this.plot.redrawOver();
    this.timeline.plot.redrawOver();
    const { clock } = this.app;
    this.app.showTime(clock.t);
  }

  /** Where things stand, in pixels. @param {Scene} scene */
  layout({ count, reach }) {
    const { width = 0, height = 0 } = this.plot;
    const spacing = (width - 40) / (count + 0.6);
    const floor = height - BELT - 5;
    const side = Math.min(0.62 * floor, 0.36 * spacing, 62);
    const unit = Math.min(0.5 * (spacing - 1.3 * side), 90) / reach;
    return {
      ...{ width, floor, side, unit, spacing },
      wide: 1.3 * side,
      rest: (/** @type {number} */ b) => 20 + spacing * (b + 0.8),
    };
  }

  paint() {
    const { clock } = this.app;
    const k = clock.index();
    const { scene } = this;
    if (!clock.arrays) return this.plot.message(this.emptyText("motion"));
    if (k < 0 || clock.arrays !== this.of || !scene) return;
    const at = this.layout(scene);
    const { count, contacts } = scene;
    const { mode, w, u } = clock.arrays;
    const centre = Array.from(
      { length: count },
      (_, b) => at.rest(b) + at.unit * (scene.place(b, k) - scene.middle[b]),
    );
    const way = contacts.map((_, c) => [0, 1, -1][mode[k * contacts.length + c]]);
    const speed = contacts.map(({ V }, c) => Math.abs(w[k * contacts.length + c] - V));
    this.#floors(at, scene, clock.t);
    this.#walls(at, scene);
    const widest = Math.max(...scene.springs.map(([, , stiffness]) => Math.abs(stiffness)));
    for (const [one, other, stiffness] of scene.springs) {
      const heavy = scene.scaled ? 2.2 * Math.sqrt(Math.abs(stiffness) / widest) : 1.1 * Math.sqrt(stiffness);
      this.#springBetween(at, scene, centre, one, other, Math.max(0.6, heavy), stiffness < 0);
    }
    contacts.forEach(({ bodies, elastic }, c) => {
      const [one, other] = bodies;
      if (other !== undefined) this.#plates(at, centre[one], centre[other], way[c], speed[c]);
      else if (elastic) {
        const foot = at.rest(one) + at.unit * (u[k * contacts.length + c] - scene.middle[one]);
        this.#foot(at, centre[one], foot, way[c] === 0);
      }
    });
    centre.forEach((x, b) => {
      const c = scene.under[b];
      if (c < 0) return this.#body(at, b, x);
      if (!contacts[c].elastic) return this.#block(at, b, x, way[c], speed[c]);
      this.#body(at, b, x);
    });
  }

  /** One belt under all, or under each body what it rubs on. @param {any} at @param {Scene} scene @param {number} t */
  #floors(at, { contacts, under, whole }, t) {
    if (whole) return this.#belt(at, 22, at.width - 22, contacts[0].V * t * at.unit, contacts[0].V);
    under.forEach((c, b) => {
      if (c < 0) return;
      const { V } = contacts[c];
      const [left, right] = [-0.44, 0.44].map((part) => at.rest(b) + part * at.spacing);
      if (V) this.#belt(at, left, right, V * t * at.unit, V);
      else this.#ground(at, left, right);
    });
  }

  /** @param {any} at @param {number} left @param {number} right */
  #ground({ floor }, left, right) {
    const c = this.plot.context;
    c.strokeStyle = colors().ink;
    c.lineWidth = 1.2;
    c.beginPath();
    c.moveTo(left, floor);
    c.lineTo(right, floor);
    for (let x = left + 6; x <= right; x += 9) {
      c.moveTo(x, floor);
      c.lineTo(x - 6, floor + 7);
    }
    c.stroke();
  }

  /**
   * A spring between neighbours or to a wall; farther ones in an arc, those of inner bodies to the
   * ground from above. Dashed: one that pushes back the wrong way.
   * @param {any} at @param {Scene} scene @param {number[]} centre
   * @param {number} one @param {number} other @param {number} width @param {boolean} dashed
   */
  #springBetween(at, scene, centre, one, other, width, dashed) {
    const c = this.plot.context;
    const half = at.wide / 2;
    const y = at.floor - 0.62 * at.side - (scene.lifted(one) ? RAISED : 0);
    c.setLineDash(dashed ? [4, 3] : []);
    c.lineWidth = Math.min(2.4, width);
    c.strokeStyle = colors().muted;
    if (other < 0) {
      const last = scene.count - 1;
      if (one === 0) this.#spring(8, centre[0] - half, y, y);
      else if (one === last) this.#spring(centre[one] + half, at.width - 8, y, y);
      else this.#hanging(at, at.rest(one) - 0.45 * half, centre[one] - 0.45 * half);
    } else if (other - one === 1) {
      const end = at.floor - 0.62 * at.side - (scene.lifted(other) ? RAISED : 0);
      this.#spring(centre[one] + half, centre[other] - half, y, end);
    } else {
      const [top, end] = [one, other].map((b) => at.floor - at.side - (scene.lifted(b) ? RAISED : 0));
      c.beginPath();
      c.moveTo(centre[one], top);
      c.quadraticCurveTo((centre[one] + centre[other]) / 2, Math.max(2, top - 40), centre[other], end);
      c.stroke();
    }
    c.setLineDash([]);
  }

  /** From the ceiling to the top of a body. @param {any} at @param {number} from @param {number} to */
  #hanging({ floor, side }, from, to) {
    const c = this.plot.context;
    const [top, bottom] = [6, floor - side];
    if (bottom - top < 12) return;
    c.beginPath();
    c.moveTo(from - 8, top);
    c.lineTo(from + 8, top);
    c.moveTo(from, top);
    for (let k = 0; k <= 8; k++) {
      const share = (k + 0.5) / 9;
      c.lineTo(from + share * (to - from) + (k % 2 ? 4 : -4), top + share * (bottom - top));
    }
    c.lineTo(to, bottom);
    c.stroke();
  }

  /** Two plates that rub, one held by each body. @param {any} at @param {number} one @param {number} other @param {number} way @param {number} speed */
  #plates(at, one, other, way, speed) {
    const c = this.plot.context;
    const of = colors();
    const [left, right] = one < other ? [one, other] : [other, one];
    const middle = (left + right) / 2;
    const y = at.floor - 0.22 * at.side;
    const lap = Math.min(26, 0.3 * (right - left - at.wide));
    c.lineWidth = 4;
    c.strokeStyle = way ? of.slip : of.stick;
    c.beginPath();
    c.moveTo(left + at.wide / 2, y - 4);
    c.lineTo(middle + lap, y - 4);
    c.moveTo(right - at.wide / 2, y + 1);
    c.lineTo(middle - lap, y + 1);
    c.stroke();
    const half = (way * Math.min(30, 14 + 40 * speed)) / 2;
    if (way) arrow(c, middle - half, y - 14, middle + half, of.slip);
  }

  /** The foot of an elastic contact: a spring down to what rubs. @param {any} at @param {number} body @param {number} foot @param {boolean} sticks */
  #foot(at, body, foot, sticks) {
    const c = this.plot.context;
    const of = colors();
    c.lineWidth = 1.5;
    c.strokeStyle = of.muted;
    const [top, bottom] = [at.floor - RAISED, at.floor - 4];
    c.beginPath();
    c.moveTo(body, top);
    for (let k = 0; k <= 5; k++) {
      const share = (k + 0.5) / 6;
      c.lineTo(body + share * (foot - body) + (k % 2 ? 5 : -5), top + share * (bottom - top));
    }
    c.lineTo(foot, bottom);
    c.stroke();
    c.fillStyle = sticks ? of.stick : of.panel;
    c.strokeStyle = sticks ? of.stick : of.slip;
    c.beginPath();
    c.rect(foot - 0.3 * at.wide, bottom - 3, 0.6 * at.wide, 7);
    c.fill();
    c.stroke();
  }

  /** A body that does not rub on the ground itself. @param {any} at @param {number} body @param {number} centre */
  #body({ floor, side, wide }, body, centre) {
    const c = this.plot.context;
    const of = colors();
    c.beginPath();
    c.roundRect(centre - wide / 2, floor - side - RAISED, wide, side, 3);
    c.fillStyle = of.panel;
    c.fill();
    c.lineWidth = 1.5;
    c.strokeStyle = of.ink;
    c.stroke();
    this.#number(body, centre, floor - RAISED - 0.5 * side, wide, of.ink);
  }

  /** @param {any} at @param {number} left @param {number} right @param {number} shift @param {number} V */
  #belt({ floor }, left, right, shift, V) {
    const c = this.plot.context;
    const of = colors();
    const r = BELT / 2;
    c.lineWidth = 1.5;
    c.strokeStyle = of.ink;
    c.beginPath();
    c.roundRect(left, floor, right - left, BELT, r);
    c.stroke();
    c.lineWidth = 1;
    c.strokeStyle = of.muted;
    c.beginPath();
    for (let x = left + r + (((shift % 24) + 24) % 24); x < right - r; x += 24) {
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
    const [middle, half] = [(left + right) / 2, Math.min(16, (right - left) / 6)];
    arrow(c, middle - half * Math.sign(V), floor + r + 3, middle + half * Math.sign(V), of.ink);
    // Of a short belt the pulleys have the room.
    if (half === 16) mathText(c, "V", middle + 26, floor + r + 7, of.ink);
  }

  /** Where a spring holds the first body, or the last. @param {any} at @param {Scene} scene */
  #walls({ width, floor }, { springs, count }) {
    const c = this.plot.context;
    c.lineWidth = 1;
    c.strokeStyle = colors().ink;
    c.beginPath();
    const held = (/** @type {number} */ body) => springs.some(([one, other]) => other < 0 && one === body);
    for (const [wall, out, body] of [
      [8, -1, 0],
      [width - 8, 1, Math.max(1, count - 1)],
    ]) {
      if (!held(body)) continue;
      c.moveTo(wall, 6);
      c.lineTo(wall, floor + 4);
      for (let y = 10; y < floor + 4; y += 7) {
        c.moveTo(wall, y);
        c.lineTo(wall + 6 * out, y + 5);
      }
    }
    c.stroke();
  }

  /** @param {number} from @param {number} to @param {number} y @param {number} end  height there */
  #spring(from, to, y, end) {
    const c = this.plot.context;
    const turns = 8;
    const lead = Math.min(12, 0.12 * (to - from));
    const step = (to - from - 2 * lead) / (2 * turns);
    const rise = (end - y) / (2 * turns);
    c.beginPath();
    c.moveTo(from, y);
    c.lineTo(from + lead, y);
    for (let k = 0; k < 2 * turns; k++)
      c.lineTo(from + lead + (k + 0.5) * step, y + (k + 0.5) * rise + (k % 2 ? 5 : -5));
    c.lineTo(to - lead, end);
    c.lineTo(to, end);
    c.lineJoin = "round";
    c.stroke();
  }

  /**
   * @param {any} at
   * @param {number} block
   * @param {number} centre
   * @param {number} way  of its slip, 0 in stick
   * @param {number} speed
   */
  #block({ floor, side, wide, spacing }, block, centre, way, speed) {
    const c = this.plot.context;
    const rides = way === 0;
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
    const ink = rides ? of.panel : of.ink;
    const worded = side > 26; // there is room; colours say it, too
    this.#number(block, centre, floor - (worded ? 0.66 : 0.5) * side, wide, ink);
    c.font = `11px ${SANS}`;
    if (worded) c.fillText(rides ? "stick" : "slip", centre, floor - 0.3 * side);
    // From its side, below the springs: above are those that hang, and those to bodies farther off.
    const [from, length] = [centre + (way * wide) / 2, Math.min(30, 0.3 * spacing, 10 + 40 * speed)];
    if (way) arrow(c, from, floor - 0.2 * side, from + way * length, of.slip);
  }

  /**
   * A body's number, as large as it has room for, if any; where contacts have other numbers, what has it.
   * @param {number} body @param {number} x @param {number} y @param {number} wide @param {string} ink
   */
  #number(body, x, y, wide, ink) {
    const c = this.plot.context;
    const size = Math.min(13, Math.round(0.6 * wide));
    c.textAlign = "center";
    c.textBaseline = "middle";
    if (size < 7) return;
    c.font = `600 ${size}px ${SANS}`;
    c.fillStyle = ink;
    const named = `${this.scene?.kind ?? ""}${body + 1}`;
    c.fillText(c.measureText(named).width < wide - 4 ? named : String(body + 1), x, y);
  }
}

/**
 * What is drawn of a motion.
 * @typedef {object} Scene
 * @property {number} count  of bodies; of contacts, where the bodies behind them are not known
 * @property {any[]} contacts
 * @property {number[][]} springs
 * @property {number[]} under  number of the contact between each body and the ground, or -1
 * @property {string} kind  what is counted, before its number: nothing of blocks
 * @property {boolean} whole  one belt runs under all
 * @property {boolean} scaled  springs are drawn beside the stiffest
 * @property {number[]} middle  of what each passes over
 * @property {number} reach  farthest from there
 * @property {(b: number, k: number) => number} place  of a body, at a sample
 * @property {(b: number) => boolean} lifted  whether it rubs itself
 */

/** @param {any} model @param {any} data @param {any} arrays @returns {Scene} */
function sceneOf(model, data, arrays) {
  const samples = arrays.t.length;
  const alone = !data.bodies;
  const count = alone ? data.contacts.length : data.bodies;
  /** @type {any[]} */
  const contacts = data.contacts.map((/** @type {any} */ one, /** @type {number} */ c) =>
    alone ? { ...one, bodies: [c] } : one,
  );
  const from = alone ? arrays.u : arrays.x;
  const wide = from.length / samples;
  const place = (/** @type {number} */ b, /** @type {number} */ k) => from[k * wide + b];
  const scaled = isStructure(model);
  const under = Array.from({ length: count }, (_, b) =>
    contacts.findIndex(({ bodies }) => bodies.length === 1 && bodies[0] === b),
  );
  const spans = under.map((_, b) => span(column(from, b, wide)));
  const middle = spans.map(([low, high]) => (scaled ? (low + high) / 2 : 0));
  const far = Math.max(...spans.map(([low, high], b) => Math.max(high - middle[b], middle[b] - low)));
  const [{ V }] = contacts;
  const alike = contacts.every((one) => one.V === V && one.bodies.length === 1 && !one.elastic);
  return {
    ...{ count, contacts, springs: data.springs, under, place, scaled, middle },
    kind: scaled ? (alone ? "contact " : "body ") : "",
    whole: alike && V !== 0 && under.every((c) => c >= 0),
    reach: scaled ? far || 1 : Math.max(far, 0.1),
    lifted: (b) => under[b] < 0 || contacts[under[b]].elastic,
  };
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
