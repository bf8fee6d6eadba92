/**
 * In the place of a server: a thread that answers what the package's kernels can answer alone.
 *
 * @import {COMPUTED} from "./connection.js"
 * @import {Model, Numbers} from "./types.js"
 * @import {Law} from "./engine.js"
 */
import { Engine, force } from "./engine.js";
import { breaksOfPower, iterated, orbits, pieces } from "./orbits.js";

const AGAIN = 1e-9; // of the domain: an orbit is back
const SAMPLES = 500; // of the whole map, to see its breaks
const PATIENCE_MS = 40_000; // for one answer: twice the server's, whose processors are quicker

/** @typedef {{data: Record<string, any>, arrays?: Record<string, Numbers>}} Found */

/** @param {string} path */
async function loaded(path) {
  const reply = await fetch(path);
  if (!reply.ok) throw new Error(`${path} does not load`);
  return reply;
}

/** @type {Promise<Record<string, Law>>} */
const laws = loaded("live/laws.json").then((reply) => reply.json());
/** @type {Map<string, Promise<Engine>>} */
const engines = new Map();

/**
 * The engine of a model, if there is one; what its law leaves out gets its default.
 * @param {Model} model @returns {Promise<Engine | null>}
 */
async function engineOf(model) {
  const name = model.friction?.law;
  const law = (await laws)[name];
  if (model.kind !== "two_block" || model.damping || model.forcing || !law) return null;
  model.friction = { ...law.defaults, ...model.friction };
  if (law.fixed.some((key) => model.friction[key] !== law.defaults[key])) return null;
  if (!engines.has(name)) engines.set(name, load(name, law));
  const engine = /** @type {Engine} */ (await engines.get(name));
  engine.take(model);
  return engine;
}

/** @param {string} name @param {Law} law */
async function load(name, law) {
  const reply = await loaded(`live/${name}.wasm`);
  return new Engine(law, await WebAssembly.compile(await reply.arrayBuffer()));
}

/** What the server says that two blocks are made of. @param {Model} model */
const twoBlocks = ({ alpha, beta, V }) => ({
  bodies: 2,
  springs: [
    [0, 1, alpha],
    [0, -1, 1],
    [1, -1, 1],
  ],
  contacts: [1, beta].map((limit, k) => ({ bodies: [k], V, limit, elastic: false })),
});

/** @type {Law["ranges"]} */
const OF_MODEL = {
  alpha: { low: 0, high: null, above: false },
  beta: { low: 0, high: null, above: true },
  V: { low: 0, high: null, above: true },
};

/** What is wrong with a model's values. @param {Model} model @param {Law} law */
function fault(model, law) {
  for (const [values, ranges] of /** @type {[any, Law["ranges"]][]} */ ([
    [model, OF_MODEL],
    [model.friction, law.ranges],
  ]))
    for (const [name, { low, high, above }] of Object.entries(ranges)) {
      const value = values[name];
      const [least, most] = law.reach[name];
      const exists = Number.isFinite(value) && (above ? value > low : value >= low) && value <= (high ?? value);
      if (exists && (!value || (value >= least && value <= most))) continue;
      const range = above ? `above ${low}` : high === null ? `at least ${low}` : `from ${low} to ${high}`;
      const far = `from ${least} to ${most}: the explorer computes no models far beyond its sliders`;
      const allowed = exists ? far : range;
      return { field: `model.${name}`, message: `${name} = ${value} is not ${allowed}` };
    }
  return undefined;
}

/** @param {Model} model @returns {[number, number]} */
const domainOf = ({ alpha, beta }) => [-(1 + beta) / (1 + 2 * alpha), (1 + beta) / (1 + 2 * alpha)];

const evenly = (/** @type {number[]} */ [low, high], /** @type {number} */ n) =>
  Float64Array.from({ length: n }, (_, k) => low + ((high - low) * k) / (n - 1));

/** @type {Record<typeof COMPUTED[number], (engine: Engine, request: any) => Iterable<Found & {name: string}>>} */
const VIEWS = {
  *event_map(engine, { model, window, points, power, max_period }) {
    const domain = domainOf(model);
    const x = evenly(window ?? domain, points);
    const { value, label } = iterated(engine, x, power)[power - 1];
    const { branch, first } = branches(value, label);
    const itineraries = power === 1 ? first.map((k) => engine.itinerary(x[k])) : undefined;
    const labels = first.map((k) => label[k].toString(16));
    const arrays = { x, f: value, branch };
    yield { name: "samples", data: { domain, labels, itineraries, breakpoints: [] }, arrays };
    const whole = pieces(engine, Float64Array.from([...evenly(domain, SAMPLES), ...x]).sort());
    const breakpoints = breaksOfPower(engine, whole, power).map((one) =>
      power === 1 ? { ...one, itineraries: sides(one.at).map((at) => engine.itinerary(at)) } : one,
    );
    yield { name: "branches", data: { domain, labels, itineraries, breakpoints }, arrays };
    if (max_period)
      for (const found of orbits(engine, whole, max_period))
        yield { name: "orbits", data: { orbits: found, complete: false } };
  },

  *cobweb(engine, { model, d, n }) {
    const orbit = new Float64Array(n + 1).fill(NaN);
    orbit[0] = d;
    for (let k = 0; k < n && Number.isFinite(orbit[k]); k++)
      orbit[k + 1] = engine.map([orbit[k]]).value[0];
    const near = AGAIN * 2 * domainOf(model)[1];
    const back = orbit.slice(0, -1).reverse();
    const period = 1 + back.findIndex((point) => Math.abs(point - orbit[n]) <= near);
    const kind = Number.isNaN(orbit[n]) ? "left" : period ? "periodic" : "unsettled";
    yield { name: "orbit", data: { end: { kind, period, status: "" } }, arrays: { orbit } };
  },

  *motion(engine, { model, d, t_end, samples }) {
    const { alpha, beta, V, friction } = model;
    const { rows, modes, status } = engine.motion(d, t_end, samples);
    const n = modes.length / 2;
    const [t, x, v, forces, interval] = [1, 2, 2, 2, 4].map((m) => new Float64Array(m * n));
    const limits = [1, beta];
    for (let k = 0; k < n; k++) {
      const [time, ...state] = rows.subarray(5 * k, 5 * k + 5);
      const e = state.slice(2);
      t[k] = time;
      const gap = (e[1] - e[0]) / (1 + 2 * alpha);
      for (const i of [0, 1]) {
        const [at, mode] = [2 * k + i, modes[2 * k + i]];
        x[at] = (e[0] + e[1] + (i ? gap : -gap)) / 2;
        v[at] = state[i] + V;
        forces[at] =
          mode === 0 ? e[i] : -mode * limits[i] * force(engine.law, friction, Math.abs(state[i]));
        interval[2 * at] = x[at] + (-limits[i] - e[i]) / (1 + alpha);
        interval[2 * at + 1] = x[at] + (limits[i] - e[i]) / (1 + alpha);
      }
    }
    const mode = Uint8Array.from(modes, (value) => (value < 0 ? 2 : value));
    const message = status ? "this page does not compute what comes then" : "";
    yield {
      name: "motion",
      data: { ...twoBlocks(model), status, message, t_end: t[n - 1], events: [] },
      arrays: { t, x, v, mode, force: forces, interval },
    };
  },

  *law({ law }, { model, range, points = 101 }) {
    const s = evenly([0, range], points);
    const forces = Float64Array.from(s, (value) => force(law, model.friction, value));
    const both = Float64Array.from({ length: 2 * points }, (_, k) => forces[k >> 1]);
    yield { name: "law", data: { names: [] }, arrays: { s, force: both, forward: both } };
  },

  *locus(_, { model }) {
    const { alpha, beta } = model;
    const at = (/** @type {number} */ e1, /** @type {number} */ e2) => {
      const gap = (e2 - e1) / (1 + 2 * alpha);
      return [(e1 + e2 - gap) / 2, (e1 + e2 + gap) / 2];
    };
    const [a, b, c, d] = [at(1, -beta), at(1, beta), at(-1, beta), at(-1, -beta)];
    const edges = [
      { name: "block 1 slips", from: a, to: b },
      { name: "block 2 slips", from: b, to: c },
    ];
    const data = { corners: [a, b, c, d], domain: domainOf(model), edges, AC: [a, c] };
    yield { name: "locus", data };
  },
};

/** Just before and just after. @param {number} at */
const sides = (at) => [at - AGAIN, at + AGAIN];

/** Runs of equal labels, counted from the left; -1 where there is no value. */
function branches(/** @type {Float64Array} */ value, /** @type {BigUint64Array} */ label) {
  const branch = new Int32Array(value.length);
  /** @type {number[]} */ const first = [];
  value.forEach((y, k) => {
    const [ok, before] = [!Number.isNaN(y), k > 0 && branch[k - 1] >= 0];
    if (ok && !(before && label[k] === label[k - 1])) first.push(k);
    branch[k] = ok ? first.length - 1 : -1;
  });
  return { branch, first };
}

/** The question of each slot that is waited for. @type {Map<string, number>} */
const wanted = new Map();

/** Messages that came meanwhile are heard, not always all. */
const pause = () => new Promise((go) => setTimeout(go));

/** @param {number} id @param {object} more */
const tell = (id, more) =>
  self.postMessage({ id, part: 0, last: true, progress: 1, data: {}, arrays: {}, ...more });

/**
 * Tell all parts, or those until it is called off.
 * @param {{id: number, slot: string, view: typeof COMPUTED[number], request: any}} message
 */
async function answer({ id, slot, view, request }) {
  const part = (/** @type {object} */ more) => tell(id, more);
  const engine = await engineOf(request.model);
  if (wanted.get(slot) !== id) return part({ cancelled: true });
  if (!engine) return part({ cancelled: true, data: { missing: true } });
  const error = fault(request.model, engine.law);
  if (error) return part({ error });
  engine.until = performance.now() + PATIENCE_MS;
  for (const { name, data, arrays = {} } of VIEWS[view](engine, request)) {
    part({ last: false, progress: 0.5, data: { part_name: name, ...data }, arrays });
    await pause();
    if (wanted.get(slot) !== id) return part({ cancelled: true }); // before more is computed
  }
  part({ data: { part_name: "end" } });
}

/** One after the other: an engine holds one model. @type {Promise<void>} */
let busy = Promise.resolve();
self.onmessage = ({ data }) => {
  if (data.cancel) {
    tell(wanted.get(data.cancel) ?? 0, { cancelled: true }); // at once: it could hear
    return void wanted.delete(data.cancel);
  }
  wanted.set(data.slot, data.id);
  busy = busy
    .then(() => answer(data))
    .catch(({ message }) => tell(data.id, { error: { message } }));
};
