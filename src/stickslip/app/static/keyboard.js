/**
 * Keys of the whole page: one table for what they do and for the help.
 *
 * @import {App} from "./app.js"
 * @import {Controls} from "./controls.js"
 * @import {Player} from "./player.js"
 * @import {Tour} from "./tour.js"
 */
import { element } from "./dom.js";
import { hasLineMap } from "./model.js";
import { PATIENT } from "./questions.js";

/**
 * @typedef {{keys: string[], shown: string, does: string, run?: (event: KeyboardEvent) => void, when?: (target: HTMLElement) => boolean}} Key
 * @param {{app: App, controls: Controls, player: Player, walk: Tour, theme: () => void, help: () => void, legend: () => void, table: () => void, tour: () => void, present: () => void, leave: () => boolean}} page
 * @returns {Key[]}
 */
export function keyTable({ app, controls, player, walk, theme, help, legend, table, tour, present, leave }) {
  const power = (/** @type {KeyboardEvent} */ { key }) =>
    app.store.update({ power: Number(key) }, "power");
  const walks = (/** @type {HTMLElement} */ target) => walk.shown && !target.matches("input");
  return [
    {
      keys: [" "],
      shown: "Space",
      does: "play or stop the motion",
      run: () => controls.playMotion(!app.clock.playing),
    },
    ...[
      { keys: ["p"], shown: "P", does: "play along the parameter", run: () => player.toggle() },
      { keys: ["["], shown: "[", does: "parameter: a step back", run: () => player.step(-1) },
      { keys: ["]"], shown: "]", does: "parameter: a step on", run: () => player.step(1) },
      { keys: ["{"], shown: "{", does: "parameter: ten steps back", run: () => player.step(-10) },
      { keys: ["}"], shown: "}", does: "parameter: ten steps on", run: () => player.step(10) },
      { keys: [..."12345678"], shown: "1 … 8", does: "power of the map", run: power },
    ].map((key) => ({ ...key, when: () => hasLineMap(app.state) })),
    { keys: ["ctrl+z", "z"], shown: "Z", does: "undo", run: () => app.store.undo() },
    { keys: ["ctrl+Z", "ctrl+y", "Z", "y"], shown: "Y", does: "redo", run: () => app.store.redo() },
    { keys: ["0"], shown: "0", does: "show everything: no zoom", run: () => showAll(app) },
    { keys: ["g"], shown: "G", does: "the tour: five steps through the paper", run: tour },
    {
      keys: ["PageDown", "ArrowRight"],
      shown: "Page Down, →",
      does: "tour: on",
      run: () => walk.step(1),
      when: walks,
    },
    {
      keys: ["PageUp", "ArrowLeft"],
      shown: "Page Up, ←",
      does: "tour: back",
      run: () => walk.step(-1),
      when: walks,
    },
    { keys: ["l"], shown: "L", does: "what the marks mean", run: legend },
    { keys: ["o"], shown: "O", does: "table of orbits, breaks and bifurcations", run: table },
    { keys: ["f"], shown: "F", does: "present: one or two views, large", run: present },
    { keys: ["t"], shown: "T", does: "light or dark", run: theme },
    {
      keys: ["Escape"],
      shown: "Esc",
      does: "leave the large views; stop playing and computing",
      run: () => leave() || stopAll(app, player),
    },
    { keys: ["?"], shown: "?", does: "this help", run: help },
    { keys: [], shown: "Tab, arrows", does: "on a slider: change it; on a plot: move the view, the time, or along the law" },
    { keys: [], shown: "+  −  0", does: "on a plot: zoom in, out, show all" },
  ];
}

/** @param {Key[]} table */
export function listen(table) {
  document.addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    const fields = "input:not([type=range]), textarea, select";
    const writes = target.matches(fields) && event.key !== "Escape";
    if (writes || event.altKey || event.defaultPrevented || document.querySelector("dialog[open]"))
      return;
    if (target.matches("button, summary") && (event.key === " " || event.key === "Enter")) return;
    const name = (event.ctrlKey || event.metaKey ? "ctrl+" : "") + event.key;
    const found = table.find(({ keys, when }) => keys.includes(name) && (when?.(target) ?? true));
    if (!found?.run) return;
    event.preventDefault();
    found.run(event);
  });
}

/** @param {Key[]} table */
export function helpDialog(table) {
  const rows = table.map(({ shown, does }) =>
    element("div", {}, element("dt", {}, element("kbd", {}, shown)), element("dd", {}, does)),
  );
  const close = element(
    "button",
    { type: "button", class: "close", onclick: () => dialog.close() },
    "Close",
  );
  const dialog = element(
    "dialog",
    { class: "help", "aria-labelledby": "help-title" },
    element("h2", { id: "help-title" }, "Keys and pointer"),
    element("dl", {}, ...rows),
    element(
      "p",
      {},
      "Click a point of the event map, of its basins or of the diagram to start the motion there. " +
        "Drag a box to zoom, turn the wheel to zoom about the pointer, double-click to see all. " +
        "Drag the line in the diagram to change its parameter. The address holds the whole state: " +
        "copy it to share what you see.",
    ),
    close,
  );
  return dialog;
}

/** @param {App} app */
function showAll(app) {
  const { diagram } = app.state;
  app.store.update(
    { windows: {}, diagram: { ...diagram, range: diagram.full, view: null } },
    "zoom",
  );
}

/** @param {App} app @param {Player} player */
function stopAll(app, player) {
  player.stop();
  for (const slot of PATIENT) app.cancel(slot);
}
