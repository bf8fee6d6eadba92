/** Colours of the drawings, from the style sheet, and the switch between light and dark. */

export const SANS = '"Inter", "Segoe UI", "Helvetica Neue", "Liberation Sans", Arial, sans-serif';
export const MATH = '"STIX Two Text", "Latin Modern Roman", "Liberation Serif", Georgia, serif';

const NAMES = [
  "ink",
  "muted",
  "grid",
  "frame",
  "panel",
  "fill",
  "blue",
  "vermillion",
  "green",
  "purple",
  "orange",
  "sky",
  "stick",
  "slip",
];

/** @type {Record<string, string>} */
let known = {};

/** The present colours, by their names in the style sheet. */
export function colors() {
  if (!known.ink) {
    const style = getComputedStyle(document.documentElement);
    known = Object.fromEntries(
      NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]),
    );
  }
  return known;
}

/**
 * Colour and dash of the k-th of many: seven colours (Okabe and Ito), then the same dashed.
 * @param {number} k
 */
export function nth(k) {
  const of = colors();
  const cycle = [of.blue, of.vermillion, of.green, of.purple, of.orange, of.sky, of.muted];
  const dashes = [[], [7, 3], [2, 3], [9, 3, 2, 3]];
  return {
    color: cycle[k % cycle.length],
    dash: dashes[Math.floor(k / cycle.length) % dashes.length],
  };
}

/**
 * What a phase of two blocks adds to the number of a colour: of 563 neighbours on maps of two blocks one
 * pair had the same.
 * @type {Record<string, number>}
 */
const WEIGHTS = { "-.": 2, ".-": 1, "--": 0, "+.": 3, ".+": 5, "+-": 3, "-+": 6, "++": 5, "..": 0 };

/**
 * Colour of a branch by its itinerary, or by its label: the same wherever and whenever it is seen.
 * @param {string} name  `-. -- ..`, or digits
 */
export function colorOf(name) {
  const weight = (/** @type {string} */ phase) =>
    WEIGHTS[phase] ?? [...phase].reduce((sum, mode) => (31 * sum + mode.charCodeAt(0)) % 65521, 0);
  return nth(name.split(" ").reduce((sum, phase) => sum + weight(phase), 0) % 7).color;
}

const media = matchMedia("(prefers-color-scheme: dark)");

/** @param {() => void} onchange */
export function watchTheme(onchange) {
  set(remembered(), onchange);
  media.addEventListener("change", () => set(remembered(), onchange));
}

/** @param {() => void} onchange */
export function switchTheme(onchange) {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  try {
    localStorage.setItem("theme", next);
  } catch {
    // a page without storage forgets the choice
  }
  set(next, onchange);
}

function remembered() {
  let kept = null;
  try {
    kept = localStorage.getItem("theme");
  } catch {
    kept = null;
  }
  return kept ?? (media.matches ? "dark" : "light");
}

function set(/** @type {string} */ theme, /** @type {() => void} */ onchange) {
  document.documentElement.dataset.theme = theme;
  known = {};
  onchange();
}

export const reducedMotion = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
