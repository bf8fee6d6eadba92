/**
 * The socket: questions by slot, answers in parts; of each slot the latest question wins.
 *
 * @import {Part, Question, Numbers} from "./types.js"
 */

const PATIENCE_MS = 120; // a question that has run this long gives way to a newer one
const SILENT_MS = 1000; // a thread that goes on for so long with what is called off is ended
const QUIET_MS = 5000; // a server that is asked something speaks each second; after so long it seems gone
const RETRY_MS = [300, 1000, 3000];

/** Views that a thread computes: of others it need not be asked. */
export const COMPUTED = /** @type {const} */ (["event_map", "cobweb", "motion", "law", "locus"]);

/** @type {Record<string, any>} */
const KINDS = { f8: Float64Array, f4: Float32Array, u1: Uint8Array, i4: Int32Array };

const ENDED = { part: 0, last: true, cancelled: true, progress: 0, data: {}, arrays: {} };

/**
 * @typedef {object} Asked
 * @property {number} id
 * @property {string} slot
 * @property {Question} question
 * @property {(part: Part) => void} onpart
 * @property {number} since
 */

/**
 * @typedef {object} Link  what carries questions there and answers back
 * @property {(hears: {onopen: () => void, onpart: (part: Part) => void, onclose: () => void, onbroken: () => void}) => void} open
 * @property {(message: object) => void} send
 * @property {boolean} [speaks]  whether it gives a sign of life while it computes
 */

/** A server. @implements {Link} */
export class Socket {
  speaks = true;

  /** @param {string} url */
  constructor(url) {
    this.url = url;
  }

  /** @param {Parameters<Link["open"]>[0]} hears */
  open({ onopen, onpart, onclose }) {
    this.socket = new WebSocket(this.url);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = onopen;
    this.socket.onmessage = (event) => onpart(decoded(event.data)[0]);
    this.socket.onclose = onclose;
  }

  /** @param {object} message */
  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}

/** A thread of this page, which knows maps and motions. @implements {Link} */
export class Thread {
  /** Slots by question, of those called off none; it computes the first. @type {Map<number, string | null>} */
  unanswered = new Map();
  vain = 0; // the question, if any, that it computes and nobody wants
  timer = 0;

  /** @param {Parameters<Link["open"]>[0]} hears */
  open(hears) {
    const { onopen, onpart, onbroken } = hears;
    this.onpart = onpart;
    this.worker = new Worker("static/live.js", { type: "module" });
    this.unanswered.clear();
    this.worker.onmessage = ({ data }) => {
      if (data.last || data.cancelled || data.error) this.unanswered.delete(data.id);
      this.#watch();
      onpart(data);
    };
    this.anew = () => {
      this.worker?.terminate();
      this.open(hears);
    };
    this.worker.onerror = () => {
      this.send = () => setTimeout(onbroken); // whatever is asked later
      onbroken();
    };
    onopen();
  }

  /** @param {any} message */
  send(message) {
    if (message.id && !COMPUTED.includes(message.view)) {
      const none = { ...ENDED, id: message.id, view: message.view, data: { missing: true } };
      setTimeout(() => this.onpart?.(none));
      return;
    }
    this.worker?.postMessage(message);
    if (message.id) this.unanswered.set(message.id, message.slot);
    else
      for (const [id, slot] of this.unanswered)
        if (slot === message.cancel) this.unanswered.set(id, null);
    this.#watch();
  }

  /** What computes one thing at a stretch does not hear that nobody wants it: another thread begins. */
  #watch() {
    const [[id, slot] = [0, ""]] = this.unanswered;
    const vain = slot === null ? id : 0;
    if (vain === this.vain) return; // also where parts come that were sent before it could hear
    this.vain = vain;
    clearTimeout(this.timer);
    if (vain) this.timer = setTimeout(() => this.anew?.(), SILENT_MS);
  }
}

export class Connection {
  /**
   * @param {Link} link
   * @param {(open: boolean, steps?: {done: number, of: number}) => void} onchange  connected or not; how far kernels are compiled
   */
  constructor(link, onchange) {
    this.link = link;
    this.onchange = onchange;
    /** @type {Map<string, Asked>} */ this.running = new Map();
    /** @type {Map<string, Asked>} */ this.waiting = new Map();
    this.nextId = 1;
    this.failures = 0;
    this.open = false;
    this.lost = false; // not before it failed: the server may be loading what computes
    this.quiet = QUIET_MS;
    this.#open();
  }

  /**
   * Ask. One question of a slot runs, one waits; a newer one takes the place of that which waits.
   * @param {string} slot
   * @param {Question} question
   * @param {(part: Part) => void} onpart
   */
  ask(slot, question, onpart) {
    const asked = { id: this.nextId++, slot, question, onpart, since: 0 };
    const running = this.running.get(slot);
    if (!running) return this.#send(asked);
    this.waiting.set(slot, asked);
    const age = performance.now() - running.since;
    setTimeout(() => this.#makeWay(running), Math.max(0, PATIENCE_MS - age));
  }

  /** Give up what a slot asks. @param {string} slot */
  cancel(slot) {
    this.waiting.delete(slot);
    const running = this.running.get(slot);
    if (!running) return;
    const { id, question } = running;
    this.#write({ cancel: slot });
    this.#receive({ ...ENDED, id, view: question.view });
  }

  /** Give up what a slot asks, and hear no more of it. @param {string} slot */
  forget(slot) {
    this.waiting.delete(slot);
    if (this.running.delete(slot)) this.#write({ cancel: slot });
  }

  /** @param {Asked} running */
  #makeWay(running) {
    const { slot } = running;
    if (this.running.get(slot) === running && this.waiting.has(slot)) this.#write({ cancel: slot });
  }

  #open() {
    this.link.open({
      onopen: () => {
        this.open = true;
        this.quiet = QUIET_MS;
        for (const asked of [...this.running.values()]) {
          this.#send(this.waiting.get(asked.slot) ?? asked); // the newer one: nothing runs by now
          this.waiting.delete(asked.slot);
        }
        this.#listen();
      },
      onpart: (part) => {
        this.#listen();
        if (this.lost) this.#stand(true);
        this.#receive(part);
      },
      onbroken: () => {
        const error = { message: "the script that computes does not load" };
        for (const { id, question } of [...this.running.values()])
          this.#receive({ ...ENDED, id, view: question.view, cancelled: false, error });
      },
      onclose: () => {
        this.open = false;
        this.#stand(false);
        const pause = RETRY_MS[Math.min(this.failures++, RETRY_MS.length - 1)];
        setTimeout(() => this.#open(), pause);
      },
    });
  }

  /** @param {boolean} answers */
  #stand(answers) {
    this.lost = !answers;
    this.onchange(answers);
  }

  /** From now on, silence counts. */
  #listen() {
    clearTimeout(this.timer);
    if (!this.open || !this.link.speaks) return;
    this.timer = setTimeout(() => {
      if (!this.running.size) return;
      this.quiet *= 2; // should it speak again: a large answer takes long on a slow line
      this.#stand(false);
    }, this.quiet);
  }

  /** @param {Asked} asked */
  #send(asked) {
    const { id, slot, question } = asked;
    if (!this.running.size) this.#listen();
    asked.since = performance.now();
    this.running.set(slot, asked);
    this.#write({ id, slot, ...question });
  }

  /** @param {object} message */
  #write(message) {
    if (this.open) this.link.send(message);
  }

  /** @param {Part} part */
  #receive(part) {
    if (part.view === "hello") {
      this.failures = 0; // not before: a full server opens the socket to say so
      return this.onchange(true, part.data.warm ? undefined : part.data.steps);
    }
    const running = [...this.running.values()].find(({ id }) => id === part.id);
    if (!running) return;
    const { slot } = running;
    const ends = part.last || part.cancelled || part.error;
    if (ends) {
      this.running.delete(slot);
      const next = this.waiting.get(slot);
      this.waiting.delete(slot);
      if (next) this.#send(next);
    }
    running.onpart(part);
  }
}

/**
 * Messages, one after the other; of each length, header, arrays, which start at multiples of eight bytes.
 * @param {ArrayBuffer} buffer
 * @returns {Part[]}
 */
export function decoded(buffer) {
  const parts = [];
  for (let at = 0; at < buffer.byteLength; ) {
    const length = new DataView(buffer).getUint32(at, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, at + 4, length)));
    /** @type {Record<string, Numbers>} */
    const arrays = {};
    at = aligned(at + 4 + length);
    for (const { name, dtype, shape } of header.arrays ?? []) {
      const count = shape.reduce((/** @type {number} */ a, /** @type {number} */ b) => a * b, 1);
      arrays[name] = new KINDS[dtype](buffer, at, count);
      at = aligned(at + arrays[name].byteLength);
    }
    parts.push({ ...header, data: header.data ?? {}, arrays });
  }
  return parts;
}

const aligned = (/** @type {number} */ at) => Math.ceil(at / 8) * 8;
