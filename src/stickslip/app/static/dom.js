/** Elements made in one call. */

/**
 * @param {string} tag
 * @param {Record<string, any>} [attributes]  `on...` are listeners, `class` and `data-` as in HTML
 * @param {(Node | string)[]} children
 * @returns {any}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children);
  return made;
}

/**
 * Open a dialog with a title and a button that closes it.
 * @param {string} title @param {string} look  its class @param {(Node | string)[]} content
 */
export function openDialog(title, look, ...content) {
  const close = element("button", { type: "button", class: "close", onclick: () => dialog.close() }, "Close");
  const dialog = element(
    "dialog",
    { class: look, "aria-labelledby": "dialog-title", onclose: () => dialog.remove() },
    element("h2", { id: "dialog-title" }, title),
    close,
    ...content,
  );
  document.body.append(dialog);
  dialog.showModal();
}

/** @type {EventTarget | null} What somebody is typing in and has not entered yet. */
let edited = null;
document.addEventListener("input", ({ target }) => (edited = target), true);
for (const end of ["change", "focusout"]) {
  document.addEventListener(end, () => (edited = null), true);
}

/**
 * Show a value in a field, but never over what somebody is typing there.
 * @param {HTMLInputElement} field @param {string} text
 */
export function write(field, text) {
  if (field !== edited) field.value = text;
}

const PATHS = {
  save: "M8 2v8M4.5 7 8 10.5 11.5 7M3 13.5h10",
  play: "M5 3v10l8-5z",
  pause: "M5 3v10M11 3v10",
  back: "M11 3v10L4 8z",
  forward: "M5 3v10l7-5z",
  undo: "M6 3 2.5 6.5 6 10M3 6.5h6.5a3.5 3.5 0 0 1 0 7H7",
  redo: "M10 3l3.5 3.5L10 10M13 6.5H6.5a3.5 3.5 0 0 0 0 7H9",
  fit: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  link: "M6.5 9.5l3-3M7 4.5 8.5 3a3.2 3.2 0 0 1 4.5 4.5L11.5 9M9 11.5 7.5 13A3.2 3.2 0 0 1 3 8.5L4.5 7",
  theme: "M8 2a6 6 0 1 0 0 12zM8 2a6 6 0 0 1 0 12",
  help: "M5.5 5.8a2.5 2.5 0 1 1 3.6 2.2c-.8.4-1.1.9-1.1 1.7M8 12.5v.3",
  legend: "M2.5 4h2M7 4h6.5M2.5 8h2M7 8h6.5M2.5 12h2M7 12h6.5",
  table: "M2.5 3h11v10h-11zM2.5 6.3h11M2.5 9.6h11M6.5 3v10",
  tour: "M4 14V2.5h8l-2 2.8 2 2.8H4",
  present: "M2.5 3h11v7.5h-11zM8 10.5v2.8M5 13.3h6",
  stop: "M4 4l8 8M12 4l-8 8",
};

/**
 * A small drawing, in the colour of the text around it.
 * @param {keyof typeof PATHS} name
 */
export function icon(name) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("class", `icon icon-${name}`);
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", PATHS[name]);
  svg.append(path);
  return svg;
}

/**
 * A button with an icon and a name.
 * @param {keyof typeof PATHS} name
 * @param {string} label
 * @param {(event: MouseEvent) => void} onclick
 * @param {Record<string, any>} [more]
 * @returns {HTMLButtonElement}
 */
export function iconButton(name, label, onclick, more = {}) {
  const names = { type: "button", class: "icon-button", "aria-label": label, title: label };
  return element("button", { ...names, onclick, ...more }, icon(name));
}

/**
 * A button that plays and, pressed, pauses.
 * @param {string} label @param {() => void} onclick
 */
export function playButton(label, onclick) {
  const button = iconButton("play", label, onclick, {
    class: "icon-button play",
    "aria-pressed": "false",
  });
  button.append(icon("pause"));
  return button;
}

/**
 * Hide a section; where the focus was in it, that goes back to where it came from, as a dialog's does.
 * @param {HTMLElement} section @param {Element | null} from @param {() => void} hide
 */
export function leave(section, from, hide) {
  const held = section.contains(document.activeElement);
  hide();
  if (held) /** @type {HTMLElement | null} */ (from)?.focus();
}
