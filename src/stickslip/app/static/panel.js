/** The frame of a view: title, what is under the pointer, progress, a menu to keep it. */
import { element, iconButton } from "./dom.js";

export class Panel {
  /**
   * @param {{id: string, title: string, exports: string[], help: string}} of
   * @param {{onexport: (format: string) => void, oncancel: () => void, onreset?: () => void}} on
   */
  constructor({ id, title, exports, help }, on) {
    this.id = id;
    this.title = element("h2", { id: `title-${id}`, title: help }, title);
    this.note = element("span", { class: "note", role: "status" });
    this.bar = element("progress", {
      max: 1,
      value: 0,
      hidden: true,
      "aria-label": `${title}: progress`,
    });
    this.cancel = iconButton("stop", `Stop computing: ${title}`, on.oncancel, {
      class: "icon-button cancel",
      hidden: true,
    });
    this.reset =
      on.onreset &&
      iconButton("fit", `Show all: ${title}`, on.onreset, {
        class: "icon-button fit",
        hidden: true,
      });
    this.body = element("div", { class: "body" });
    const menu = exports.length ? [exportMenu(title, exports, on.onexport)] : [];
    const header = element(
      "header",
      {},
      this.title,
      this.note,
      this.cancel,
      ...(this.reset ? [this.reset] : []),
      ...menu,
    );
    this.section = element(
      "section",
      { class: `panel panel-${id}`, "data-panel": id, "aria-labelledby": `title-${id}` },
      header,
      this.bar,
      this.body,
    );
    this.timer = 0;
  }

  /** Show how far an answer is; quick ones show nothing. @param {number | null} progress */
  busy(progress) {
    clearTimeout(this.timer);
    this.section.toggleAttribute("data-busy", progress !== null);
    if (progress === null) {
      this.bar.hidden = this.cancel.hidden = true;
      return;
    }
    this.bar.value = progress;
    if (this.bar.hidden) {
      this.timer = setTimeout(() => (this.bar.hidden = this.cancel.hidden = false), 350);
    }
  }

  /** @param {string} text @param {boolean} [isError] */
  say(text, isError = false) {
    this.note.textContent = text;
    this.note.title = text;
    this.note.classList.toggle("error", isError);
  }
}

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

/** @param {string} title @param {string[]} exports @param {(format: string) => void} onexport */
function exportMenu(title, exports, onexport) {
  const button = iconButton("save", `Save or copy: ${title}`, () => toggle(list.hidden), {
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
  const list = element(
    "div",
    { class: "menu", role: "menu", "aria-label": `Save or copy: ${title}`, hidden: true },
    ...items,
  );
  const wrapper = element("div", { class: "menu-anchor" }, button, list);

  function toggle(/** @type {boolean} */ open) {
    list.hidden = !open;
    button.setAttribute("aria-expanded", String(open));
    if (open) items[0].focus();
  }
  wrapper.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    if (list.hidden) return;
    const at = items.indexOf(/** @type {any} */ (document.activeElement));
    const steps = /** @type {Record<string, number>} */ ({ ArrowDown: 1, ArrowUp: -1 });
    if (event.key === "Escape") (toggle(false), button.focus());
    else if (steps[event.key]) items[(at + steps[event.key] + items.length) % items.length].focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  wrapper.addEventListener("focusout", (/** @type {FocusEvent} */ event) => {
    if (!wrapper.contains(/** @type {Node | null} */ (event.relatedTarget))) toggle(false);
  });
  return wrapper;
}
