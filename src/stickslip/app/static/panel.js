/**
 * The frame of a view: title, the state of its answer, what that leaves undecided, a sentence on what
 * it shows, a menu to keep it.
 *
 * @import {Standing} from "./answers.js"
 */
import { element, iconButton, openDialog } from "./dom.js";
import { spelled } from "./numbers.js";

const MOMENT_MS = 350;

export class Panel {
  /**
   * @param {{id: string, title: string, exports: string[], help: string}} of
   * @param {{onexport: (format: string) => void, oncancel: () => void, onreset: () => void}} on
   */
  constructor({ id, title, exports, help }, on) {
    this.id = id;
    this.title = element("h2", { id: `title-${id}`, title: help });
    this.badge = element("span", { class: "badge" });
    const onclick = () => this.#showUnresolved();
    this.incomplete = element("button", { type: "button", class: "incomplete", hidden: true, onclick });
    /** What the answer leaves undecided. */
    this.unresolved = "";
    this.sentence = element("p", { class: "sentence", id: `sentence-${id}` });
    this.bar = element("progress", { max: 1, value: 0, hidden: true });
    this.cancel = iconButton("stop", "", on.oncancel, { class: "icon-button cancel", hidden: true });
    this.reset = iconButton("fit", "", on.onreset, { class: "icon-button fit", hidden: true });
    this.body = element("div", { class: "body" });
    const menu = exportMenu(exports, on.onexport);
    this.formats = menu.items;
    /** What has the panel's title in its name. @type {[HTMLElement, string][]} */
    this.named = [
      [this.bar, "Progress"],
      [this.cancel, "Stop computing"],
      [this.reset, "Show all"],
      [menu.button, "Save or copy"],
      [menu.list, "Save or copy"],
    ];
    this.name(title);
    const state = [this.badge, this.incomplete];
    const header = element("header", {}, this.title, ...state, this.cancel, this.reset);
    if (exports.length) header.append(menu.wrapper);
    this.section = element(
      "section",
      {
        class: `panel panel-${id}`,
        "data-panel": id,
        "aria-labelledby": `title-${id}`,
        "aria-describedby": `sentence-${id}`,
      },
      header,
      this.bar,
      this.sentence,
      this.body,
    );
    /** @type {Record<string, number>} */ this.timers = {};
  }

  /** Show the state of the answer; what lasts a moment shows nothing. @param {Standing} [standing] */
  stand(standing) {
    const { kind, reason, progress } = standing ?? { kind: "empty", reason: "", progress: null };
    if (this.section.dataset.state !== kind) this.section.dataset.state = kind;
    const label = [LABELS[kind], reason].filter(Boolean).join(": ");
    if (this.badge.title !== label) {
      this.badge.title = label;
      this.badge.textContent = kind === "example" ? LABELS[kind] : label;
    }
    const busy = progress !== null;
    if (busy) this.bar.value = progress;
    this.section.toggleAttribute("data-busy", busy);
    this.#lasts("waits", busy, (on) => (this.bar.hidden = this.cancel.hidden = !on));
    this.#lasts("dim", kind === "stale" || kind === "failed");
  }

  /** Say that an answer leaves something undecided. @param {string[]} texts */
  list(texts) {
    const unresolved = texts.join("\n");
    if (unresolved === this.unresolved) return;
    this.unresolved = unresolved;
    this.incomplete.hidden = !texts.length;
    this.incomplete.textContent = `incomplete: ${texts.length} unresolved`;
  }

  #showUnresolved() {
    const items = spelled(this.unresolved).split("\n").map((text) => element("li", {}, text));
    openDialog(`${this.title.textContent}: unresolved`, "unresolved", element("ul", {}, ...items));
  }

  /**
   * Mark what has been so for more than a moment: styles that come and go cost every frame.
   * @param {string} mark @param {boolean} on @param {(on: boolean) => void} [then]
   */
  #lasts(mark, on, then = () => {}) {
    if (on === mark in this.timers) return;
    const show = (/** @type {boolean} */ shown) => {
      this.section.toggleAttribute(`data-${mark}`, shown);
      then(shown);
    };
    if (on) this.timers[mark] = setTimeout(() => show(true), MOMENT_MS);
    else {
      clearTimeout(this.timers[mark]);
      delete this.timers[mark];
      show(false);
    }
  }

  /** Offer some of the formats. @param {(format: string) => boolean} isOffered */
  offer(isOffered) {
    for (const item of this.formats) item.hidden = !isOffered(item.dataset.format ?? "");
  }

  /** Set the title, with an exponent, and what is named after it. @param {string} text @param {number} [power] */
  name(text, power) {
    const whole = `${text}${power ?? ""}`;
    if (this.title.textContent === whole) return;
    this.title.replaceChildren(text);
    if (power !== undefined) this.title.append(element("sup", {}, String(power)));
    for (const [made, does] of this.named) {
      made.setAttribute("aria-label", `${does}: ${whole}`);
      if (made.matches("button")) made.title = `${does}: ${whole}`;
    }
  }

  /** Say in a sentence what is seen now. @param {string} text */
  say(text) {
    text = spelled(text);
    if (this.sentence.textContent === text) return;
    this.sentence.textContent = this.sentence.title = text; // small panels cut it
  }
}

/** @type {Record<string, string>} */
const LABELS = {
  computing: "computing",
  example: "shipped answer",
  stale: "older values",
  failed: "failed",
};

/** @type {Record<string, string>} */
const FORMATS = {
  svg: "Picture, SVG",
  png: "Picture, PNG",
  csv: "Data, CSV",
  json: "Data, JSON",
  gif: "Motion, GIF",
  mp4: "Motion, MP4",
  python: "Copy as Python",
};

/** @param {string[]} exports @param {(format: string) => void} onexport */
function exportMenu(exports, onexport) {
  const button = iconButton("save", "", () => toggle(list.hidden), {
    "aria-haspopup": "menu",
    "aria-expanded": "false",
    class: "icon-button export",
  });
  const items = exports.map((format) =>
    element(
      "button",
      {
        type: "button",
        role: "menuitem",
        tabindex: "-1",
        "data-format": format,
        onclick: () => {
          toggle(false);
          button.focus();
          onexport(format);
        },
      },
      FORMATS[format] ?? format,
    ),
  );
  const list = element("div", { class: "menu", role: "menu", hidden: true }, ...items);
  const offered = () => items.filter(({ hidden }) => !hidden);
  const wrapper = element("div", { class: "menu-anchor" }, button, list);

  function toggle(/** @type {boolean} */ open) {
    list.hidden = !open;
    button.setAttribute("aria-expanded", String(open));
    if (open) offered()[0].focus();
  }
  wrapper.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    if (list.hidden) return;
    const some = offered();
    const at = some.indexOf(/** @type {any} */ (document.activeElement));
    const steps = /** @type {Record<string, number>} */ ({ ArrowDown: 1, ArrowUp: -1 });
    if (event.key === "Escape") {
      toggle(false);
      button.focus();
    } else if (steps[event.key]) some[(at + steps[event.key] + some.length) % some.length].focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  wrapper.addEventListener("focusout", (/** @type {FocusEvent} */ event) => {
    if (!wrapper.contains(/** @type {Node | null} */ (event.relatedTarget))) toggle(false);
  });
  return { wrapper, button, list, items };
}
