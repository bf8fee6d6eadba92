/**
 * The package's kernels in the browser: maps and motions of two equal blocks with one law.
 *
 * Arguments have places in the module's memory; a call takes none and leaves what it found there.
 *
 * @typedef {object} Law  a friction law, as `laws.json` describes it
 * @property {string[]} parameters
 * @property {Record<string, number>} defaults
 * @property {string[]} fixed  what keeps its default in this code
 * @property {Record<string, {low: number, high: number | null, above: boolean}>} ranges
 * @property {Record<string, [number, number]>} reach  beyond the sliders, of the model's numbers, too
 * @property {number} force  node of the force
 * @property {number[]} constants  nodes that stand behind the parameters in a row
 * @property {Record<string, [string, number[], number, string]>} nodes  operation, operands, value, name
 *
 * @typedef {object} Samples  of a map at some points
 * @property {Float64Array} value
 * @property {Float64Array} slope
 * @property {BigUint64Array} label  what the motion goes through, as a number
 */

const PAGE = 65536;
const STACK = 1 << 19; // it ends where arguments begin
const OK = 0n;

const TOO_LONG = "took too long. Ask for a smaller window, fewer points, shorter periods or motions.";

/** @type {Record<string, any>} */
const KINDS = {
  f8: Float64Array,
  i8: BigInt64Array,
  u8: BigUint64Array,
  i1: Int8Array,
};

/** @type {Record<string, (a: number, b: number) => number>} */
const ARITHMETIC = {
  add: (a, b) => a + b,
  subtract: (a, b) => a - b,
  multiply: (a, b) => a * b,
  divide: (a, b) => a / b,
  power: (a, b) => a ** b,
  negative: (a) => -a,
  reciprocal: (a) => 1 / a,
};

/**
 * Nodes of a law's formula at a slip speed.
 * @param {Law} law @param {Record<string, number>} values @param {number} s
 * @returns {Record<string, number>}
 */
function evaluated(law, values, s) {
  /** @type {Record<string, number>} */
  const known = {};
  // Operands have smaller numbers, and keys that are numbers come in their order.
  for (const [number, [op, args, value, name]] of Object.entries(law.nodes)) {
    const [a, b] = args.map((arg) => known[arg]);
    if (op === "constant") known[number] = value;
    else if (op === "symbol") known[number] = name === "s" ? s : values[name];
    else known[number] = (ARITHMETIC[op] ?? /** @type {any} */ (Math)[op])(a, b);
  }
  return known;
}

/** @param {Law} law @param {Record<string, number>} values @param {number} s */
export const force = (law, values, s) => evaluated(law, values, s)[law.force];

export class Engine {
  /** @param {Law} law @param {WebAssembly.Module} module */
  constructor(law, module) {
    const [section] = WebAssembly.Module.customSections(module, "stickslip");
    const { places, end, filled } = JSON.parse(new TextDecoder().decode(section));
    this.law = law;
    this.until = Infinity; // when it gives up, as `performance.now` counts
    this.places = places;
    this.memory = new WebAssembly.Memory({ initial: Math.ceil(end / PAGE) });
    for (const [at, hex] of filled) this.#bytes(at, hex.length / 2).set(bytesOf(hex));
    const pointer = new WebAssembly.Global({ value: "i32", mutable: true }, STACK);
    const table = new WebAssembly.Table({ initial: 16, element: "anyfunc" });
    const env = {
      ...libm(module),
      __linear_memory: this.memory,
      __stack_pointer: pointer,
      __indirect_function_table: table,
    };
    /** @type {any} */
    this.entries = new WebAssembly.Instance(module, { env }).exports;
  }

  /** @param {number} at @param {number} length */
  #bytes(at, length) {
    return new Uint8Array(this.memory.buffer, at, length);
  }

  /** Numbers of an argument: an array over the module's memory. @param {string} name @returns {any} */
  array(name) {
    const [at, kind, shape] = this.places[name];
    const count = shape.reduce((/** @type {number} */ a, /** @type {number} */ b) => a * b, 1);
    return new KINDS[kind](this.memory.buffer, at, count);
  }

  /** @param {Record<string, any>} model  of two blocks with this law, whose parameters are all given */
  take(model) {
    const { law } = this;
    for (const entry of ["map", "motion"]) {
      for (const name of ["alpha", "beta", "V"])
        this.array(`${entry}.system.${name}`)[0] = model[name];
      const rows = this.array(`${entry}.laws`);
      const nodes = evaluated(law, model.friction, 0);
      const columns = [0, nodes[law.force], nodes[law.force], Infinity, -1];
      columns.push(...law.parameters.map((name) => model.friction[name]));
      columns.push(...law.constants.map((node) => nodes[node]));
      for (const block of [0, 1]) rows.set(columns, (block * rows.length) / 2);
    }
  }

  /** @param {ArrayLike<number>} d  as many as there are @returns {Samples} */
  map(d) {
    const points = this.array("map.points");
    const outputs = ["value", "derivative", "label"].map((name) => this.array(`map.outputs.${name}`));
    const status = this.array("map.outputs.status");
    const [value, slope, label] = outputs.map((output) => new output.constructor(d.length));
    for (let from = 0; from < d.length; from += points.length) {
      if (performance.now() > this.until) throw new Error(TOO_LONG);
      const count = Math.min(points.length, d.length - from);
      for (let k = 0; k < count; k++) points[k] = d[from + k];
      this.array("map.stop")[0] = BigInt(count);
      this.entries.map();
      [value, slope, label].forEach((all, k) => all.set(outputs[k].subarray(0, count), from));
      for (let k = 0; k < count; k++)
        if (status[k] !== OK) value[from + k] = slope[from + k] = NaN;
    }
    return { value, slope, label };
  }

  /** Modes of each phase from d to the next, as text. @param {number} d */
  itinerary(d) {
    const modes = this.array("map.itinerary");
    this.map([d]);
    const events = Number(this.array("map.outputs.n_events")[0]);
    const phases = [];
    for (let k = 0; k <= Math.min(events, modes.length / 2 - 1); k++)
      phases.push([...modes.slice(2 * k, 2 * k + 2)].map((mode) => "-.+"[mode + 1]).join(""));
    return phases.join(" ");
  }

  /**
   * From a global stick phase: rows of t, w, e and of modes.
   * @param {number} d @param {number} end @param {number} samples
   */
  motion(d, end, samples) {
    for (const [name, value] of [
      ["d", d],
      ["t_end", end],
      ["every", end / (samples - 1)],
    ])
      this.array(`motion.${name}`)[0] = value;
    this.entries.motion();
    const [count, status] = this.array("motion.count");
    return {
      rows: this.array("motion.rows").slice(0, 5 * Number(count)),
      modes: this.array("motion.modes").slice(0, 2 * Number(count)),
      status: Number(status),
    };
  }
}

/** @param {string} hex */
const bytesOf = (hex) =>
  Uint8Array.from(hex.match(/../g) ?? [], (pair) => Number.parseInt(pair, 16));

/** Functions of C's library that a module asks for. @param {WebAssembly.Module} module */
function libm(module) {
  const wanted = WebAssembly.Module.imports(module).filter(({ kind }) => kind === "function");
  return Object.fromEntries(wanted.map(({ name }) => [name, /** @type {any} */ (Math)[name]]));
}
