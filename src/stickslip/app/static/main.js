/**
 * Starts the page: what the server allows, the state of the address, the views, the controls.
 *
 * @import {Limits, Preset} from "./types.js"
 */
import { App } from "./app.js";
import { Controls } from "./controls.js";
import { element, icon, iconButton, leave } from "./dom.js";
import { helpDialog, keyTable, listen } from "./keyboard.js";
import { copy } from "./keep.js";
import { Large } from "./large.js";
import { showLegend } from "./legend.js";
import { Player } from "./player.js";
import { Shipped } from "./shipped.js";
import { completeState, fromAddress, sectionOf, toFragment } from "./state.js";
import { reducedMotion, switchTheme, watchTheme } from "./theme.js";
import { blockCount, hasLineMap, hasSpaceMap, mapOf, sticksAsOne } from "./model.js";
import { Tour } from "./tour.js";
import { BasinsView } from "./views/basins.js";
import { CycleView } from "./views/cycle.js";
import { DiagramView } from "./views/diagram.js";
import { LawView } from "./views/law.js";
import { MapView } from "./views/map.js";
import { MechanismView } from "./views/mechanism.js";
import { SectionView } from "./views/section.js";
import { TableView } from "./views/table.js";
import { PlaneView, PortraitView } from "./views/motion.js";

const ADDRESS_MS = 200;

/** @param {string} name */
const read = async (name) => (await fetch(`static/shipped/${name}.json`)).json();

/**
 * The state that an address asks for, whole or by the name of a preset; of one that cannot be read the
 * first preset, and why.
 * @param {string} address @param {Limits} limits @param {Preset[]} presets
 */
function stateOfAddress(address, limits, presets) {
  const plain = new URL(address).hash.slice(1).replaceAll("+", "%2B"); // as it is typed: a formula's sum
  const given = new Map(new URLSearchParams(plain));
  const ofFirst = [...given.keys()].every((key) => key === "section");
  const name = given.get("preset") ?? (ofFirst ? presets[0].name : undefined);
  const preset = presets.find((one) => one.name === name);
  try {
    if (name && !preset) throw new Error(`there is no preset ${name}`);
    const section = sectionOf(given);
    const state = preset
      ? completeState(limits, section ? { ...preset.state, section } : preset.state)
      : fromAddress(limits, given);
    return { state, fault: "" };
  } catch (error) {
    const [{ state, title }] = presets;
    const why = /** @type {Error} */ (error).message;
    const fault = `The address cannot be read: ${why}. Shown is ${title}.`;
    return { state: completeState(limits, state), fault };
  }
}

/** How far the kernels are. @param {{done: number, of: number}} [steps] */
const preparing = (steps) =>
  steps
    ? `Preparing the kernels, the first time only: ${steps.done} of ${steps.of} steps.`
    : "";

/** @param {App} app @param {HTMLElement} main */
function addViews(app, main) {
  const most = Math.max(...app.limits.models.map(({ blocks }) => blocks?.max ?? 1));
  const portraits = Array.from({ length: most }, (_, block) => new PortraitView(app, block));
  const law = new LawView(app);
  const map = new MapView(app, "map");
  const line = [
    map,
    new MechanismView(app),
    new DiagramView(app),
    new BasinsView(app, map.plot),
    new MapView(app, "power"),
  ];
  const plane = new PlaneView(app);
  const cycle = new CycleView(app);
  for (const view of [line[0], ...line.slice(2)]) view.isFor = hasLineMap;
  plane.isFor = (state) => hasLineMap(state) && sticksAsOne(state.model);
  cycle.isFor = (state) => !hasLineMap(state);
  const section = new SectionView(app);
  section.isFor = hasSpaceMap;
  const table = new TableView(app);
  const inMain = [...line, ...portraits, plane, table, cycle, section];
  main.append(...inMain.map((view) => view.panel.section));
  app.views = [law, ...inMain];
  app.presentable = inMain.filter((view) => view !== table);
  return { law, table };
}

/** Show the table in the place of the small views, or these. @param {App} app @param {TableView} table */
function toggleTable(app, table) {
  table.open = !table.open;
  if (!table.open) return leave(table.panel.section, table.from, () => app.changed());
  table.from = document.activeElement;
  app.changed();
  if (!hasLineMap(app.state)) return app.announce("The table is of maps of the line: this model has none");
  table.panel.section.scrollIntoView({ block: "nearest" });
  table.panel.body.querySelector("button.name")?.focus();
}

async function start() {
  const [limits, presets, entries] = await Promise.all(
    ["limits", "presets", "index"].map(read),
  );
  const status = /** @type {HTMLElement} */ (document.querySelector(".connection"));
  const toast = /** @type {HTMLElement} */ (document.querySelector(".toast"));
  const { state, fault } = stateOfAddress(location.href, limits, presets);
  const app = new App(
    limits,
    state,
    new Shipped(entries),
    (open, steps) => {
      status.textContent = open ? preparing(steps) : "The server does not answer; waiting for it …";
      status.classList.toggle("error", !open);
    },
  );
  if (app.alone)
    status.textContent =
      'Maps and motions of two blocks are computed here, the rest was before. For all: pip install "stickslip[app]"';
  let toastTimer = 0;
  app.announce = (message, lasts = false) => {
    toast.textContent = message;
    clearTimeout(toastTimer);
    if (!lasts) toastTimer = setTimeout(() => (toast.textContent = ""), 4000);
  };
  const main = /** @type {HTMLElement} */ (document.querySelector("main"));
  const { law, table } = addViews(app, main);
  const player = new Player(app);
  const side = /** @type {HTMLElement} */ (document.querySelector(".controls"));
  const controls = new Controls(app, presets, player, side);
  controls.lawHost.append(law.panel.section);

  const redraw = () => app.views.forEach((view) => view.refresh());
  const theme = () => switchTheme(redraw);
  const tour = new Tour(app, presets, side);
  const large = new Large(app);
  const does = {
    theme,
    present: () => large.toggle(),
    help: () => help.showModal(),
    legend: showLegend,
    table: () => {
      large.end();
      toggleTable(app, table);
    },
    tour: () => tour.toggle(),
  };
  const keys = keyTable({ app, controls, player, leave: () => large.end(), walk: tour, ...does });
  const help = helpDialog(keys);
  document.body.append(help);
  listen(keys);
  addTools(app, does, large.choices);
  watchTheme(redraw);
  keepAddress(app, (address) => {
    const asked = stateOfAddress(address, limits, presets);
    app.store.replace(asked.state);
    controls.mark(null, asked.fault);
  });
  const arrange = () => {
    main.dataset.map = mapOf(app.state).kind;
    main.dataset.contacts = String(blockCount(app.state.model));
  };
  app.store.subscribe(arrange);
  arrange();
  app.changed();
  controls.mark(null, fault);
  if (!reducedMotion()) controls.playMotion(true);
  document.documentElement.dataset.ready = "true";
  Object.assign(window, { explorer: app });
}

/**
 * @param {App} app
 * @param {Record<"theme" | "help" | "legend" | "table" | "tour" | "present", () => void>} does
 * @param {HTMLElement[]} choices  of what is presented
 */
function addTools(app, does, choices) {
  const undo = iconButton("undo", "Undo", () => app.store.undo());
  const redo = iconButton("redo", "Redo", () => app.store.redo());
  const able = () => {
    undo.disabled = !app.store.past.length;
    redo.disabled = !app.store.future.length;
  };
  app.store.subscribe(able);
  able();
  /** @type {["tour" | "legend" | "table" | "present", string][]} */
  const named = [
    ["present", "Present"],
    ["tour", "Tour"],
    ["table", "Table"],
    ["legend", "Legend"],
  ];
  document.querySelector(".tools")?.append(
    ...choices,
    ...named.map(([name, text]) =>
      element(
        "button",
        { type: "button", class: "tool", "aria-label": text, onclick: does[name] },
        icon(name),
        element("span", {}, text),
      ),
    ),
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

/**
 * Write the state into the address, and follow an address that is typed, also where a state is written over
 * it before the browser tells of it.
 * @param {App} app @param {(address: string) => void} follow
 */
function keepAddress(app, follow) {
  let timer = 0;
  const write = () => history.replaceState(null, "", `#${toFragment(app.limits, app.state)}`);
  app.store.subscribe(() => {
    clearTimeout(timer);
    timer = setTimeout(write, ADDRESS_MS);
  });
  addEventListener("hashchange", ({ newURL }) => follow(newURL));
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
