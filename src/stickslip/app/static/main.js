/**
 * Starts the page: what the server allows, the state of the address, the views, the controls.
 *
 * @import {Limits, Preset, State} from "./types.js"
 */
import { App } from "./app.js";
import { Controls } from "./controls.js";
import { element, iconButton } from "./dom.js";
import { helpDialog, keyTable, listen } from "./keyboard.js";
import { copy } from "./keep.js";
import { Player } from "./player.js";
import { completeState, fromFragment, toFragment } from "./state.js";
import { reducedMotion, switchTheme, watchTheme } from "./theme.js";
import { hasLineMap } from "./model.js";
import { BasinsView } from "./views/basins.js";
import { CycleView } from "./views/cycle.js";
import { DiagramView } from "./views/diagram.js";
import { LawView } from "./views/law.js";
import { MapView } from "./views/map.js";
import { MechanismView } from "./views/mechanism.js";
import { PlaneView, PortraitView } from "./views/motion.js";

const ADDRESS_MS = 200;
const MOST_PORTRAITS = 8;

/** @param {string} path */
const read = async (path) => (await fetch(new URL(path, location.href))).json();

/** The state that the address asks for: whole, by the name of a preset, or none. */
function stateOfAddress(/** @type {Limits} */ limits, /** @type {Preset[]} */ presets) {
  const fragment = location.hash.slice(1);
  const wanted = new URLSearchParams(fragment).get("preset");
  const preset = presets.find(({ name }) => name === wanted) ?? presets[0];
  return fromFragment(limits, fragment) ?? completeState(limits, preset?.state ?? {});
}

/** @param {App} app @param {HTMLElement} main */
function addViews(app, main) {
  const portraits = Array.from(
    { length: MOST_PORTRAITS },
    (_, block) => new PortraitView(app, block),
  );
  const law = new LawView(app);
  const line = [
    new MapView(app, "map"),
    new MechanismView(app),
    new DiagramView(app),
    new BasinsView(app),
    new MapView(app, "power"),
  ];
  const plane = new PlaneView(app);
  const cycle = new CycleView(app);
  for (const view of [line[0], ...line.slice(2), plane])
    view.isFor = ({ model }) => hasLineMap(model);
  cycle.isFor = ({ model }) => !hasLineMap(model);
  const inMain = [...line, ...portraits, plane, cycle];
  main.append(...inMain.map((view) => view.panel.section));
  app.views = [law, ...inMain];
  return law;
}

async function start() {
  const [limits, presets] = await Promise.all([read("limits.json"), read("presets.json")]);
  const status = /** @type {HTMLElement} */ (document.querySelector(".connection"));
  const toast = /** @type {HTMLElement} */ (document.querySelector(".toast"));
  const app = new App(limits, stateOfAddress(limits, presets), (open, warm) => {
    status.textContent = !open
      ? "No connection to the server; trying again …"
      : warm
        ? ""
        : "Compiling, the first time only …";
    status.classList.toggle("error", !open);
  });
  let toastTimer = 0;
  app.announce = (message) => {
    toast.textContent = message;
    clearTimeout(toastTimer);
    toastTimer = setTimeout(() => (toast.textContent = ""), 4000);
  };
  const main = /** @type {HTMLElement} */ (document.querySelector("main"));
  const law = addViews(app, main);
  const player = new Player(app);
  const side = /** @type {HTMLElement} */ (document.querySelector(".controls"));
  const controls = new Controls(app, presets, player, side);
  controls.lawHost.append(law.panel.section);

  const redraw = () => app.views.forEach((view) => view.refresh());
  const theme = () => switchTheme(redraw);
  const table = keyTable({ app, controls, player, theme, help: () => help.showModal() });
  const help = helpDialog(table);
  document.body.append(help);
  listen(table, player);
  addTools(app, { theme, help: () => help.showModal() });
  watchTheme(redraw);
  keepAddress(app, limits, presets);
  const arrange = () => (main.dataset.kind = app.state.model.kind);
  app.store.subscribe(arrange);
  arrange();
  app.changed();
  if (!reducedMotion()) controls.playMotion(true);
  document.documentElement.dataset.ready = "true";
  Object.assign(window, { explorer: app });
}

/** @param {App} app @param {{theme: () => void, help: () => void}} does */
function addTools(app, does) {
  const undo = iconButton("undo", "Undo", () => app.store.undo());
  const redo = iconButton("redo", "Redo", () => app.store.redo());
  const able = () => {
    undo.disabled = !app.store.past.length;
    redo.disabled = !app.store.future.length;
  };
  app.store.subscribe(able);
  able();
  document.querySelector(".tools")?.append(
    undo,
    redo,
    iconButton("link", "Copy the address of what you see", () => {
      history.replaceState(null, "", `#${toFragment(app.limits, app.state)}`);
      copy(location.href, "Copied: the address of what you see", app.announce);
    }),
    iconButton("theme", "Light or dark", does.theme),
    iconButton("help", "Help", does.help),
  );
}

/** Write the state into the address, and follow an address that is typed. */
function keepAddress(
  /** @type {App} */ app,
  /** @type {Limits} */ limits,
  /** @type {Preset[]} */ presets,
) {
  let timer = 0;
  app.store.subscribe((state) => {
    clearTimeout(timer);
    timer = setTimeout(
      () => history.replaceState(null, "", `#${toFragment(limits, state)}`),
      ADDRESS_MS,
    );
  });
  addEventListener("hashchange", () => app.store.replace(stateOfAddress(limits, presets)));
}

start().catch((error) => {
  const main = document.querySelector("main");
  main?.append(
    element(
      "p",
      { class: "error", role: "alert" },
      `The page could not start: ${error.message}. Is the server running?`,
    ),
  );
});
