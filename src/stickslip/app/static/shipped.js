/**
 * Answers that come with the package, one for each view of each preset.
 *
 * @import {Part, Question} from "./types.js"
 */
import { decoded } from "./connection.js";
import { same } from "./state.js";

const FINENESS = new Set(["points", "values", "samples", "resolution", "range", "n"]);

/** What a question is about: not how finely it is answered. @param {Question} question */
function essence({ view, request }) {
  // The range of a law is how far it is drawn, that of a diagram is what it is about.
  const fine = (/** @type {string} */ name) =>
    view === "diagram" ? name === "values" : FINENESS.has(name);
  return {
    view,
    request: Object.fromEntries(Object.entries(request).filter(([name]) => !fine(name))),
  };
}

/**
 * Whether two questions differ in fineness alone.
 * @param {Question} one @param {Question} other
 */
export const alike = (one, other) =>
  one === other || (one.view === other.view && same(essence(one), essence(other)));

export class Shipped {
  /** @param {(Question & {file: string})[]} entries */
  constructor(entries) {
    this.entries = entries;
    /** @type {Map<string, Promise<Part[]>>} */ this.read = new Map();
  }

  /** The parts of an answer, if there is one to this. @param {Question} question */
  find(question) {
    const file = this.entries.find((entry) => alike(entry, question))?.file;
    if (!file) return undefined;
    const read = this.read.get(file) ?? load(file);
    this.read.set(file, read);
    read.catch(() => this.read.delete(file)); // who asks again has it loaded again
    return read;
  }
}

/** @param {string} file @returns {Promise<Part[]>} */
async function load(file) {
  const reply = await fetch(`static/shipped/${file}`);
  if (!reply.ok || !reply.body) throw new Error(`the server answered ${reply.status}`);
  const plain = reply.body.pipeThrough(new DecompressionStream("gzip"));
  return decoded(await new Response(plain).arrayBuffer());
}
