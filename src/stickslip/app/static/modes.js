/** Itineraries as bars: a column for each phase, a row for each block. */
import { element } from "./dom.js";

const WIDE = 9;
const HIGH = 6;
/** @type {Record<string, string>} */
const NAMES = { ".": "sticks", "+": "slips forward", "-": "slips back" };
/** @type {Record<string, string>} */
const SHAPES = {
  ".": `h${WIDE - 1}v${HIGH - 1}h${1 - WIDE}z`,
  "+": `l${WIDE - 2},${(HIGH - 1) / 2}l${2 - WIDE},${(HIGH - 1) / 2}z`,
  "-": `m${WIDE - 2},0l${2 - WIDE},${(HIGH - 1) / 2}l${WIDE - 2},${(HIGH - 1) / 2}z`,
};

/**
 * @param {string} itinerary  as the library writes it: `-. -- ..`; two of them, with a bar between,
 *   for an orbit through a jump
 */
export function modeBar(itinerary) {
  const space = "http://www.w3.org/2000/svg";
  const phases = itinerary.trim().split(/\s+/);
  const blocks = phases[0].length;
  const svg = document.createElementNS(space, "svg");
  const size = { width: WIDE * phases.length, height: HIGH * blocks };
  for (const [name, value] of Object.entries({
    class: "modes",
    role: "img",
    "aria-label": spoken(phases),
    ...size,
  }))
    svg.setAttribute(name, String(value));
  phases.forEach((phase, k) =>
    [...phase].forEach((mode, block) => {
      const path = document.createElementNS(space, "path");
      if (mode === ".") path.setAttribute("class", "sticks");
      path.setAttribute("d", `M${k * WIDE + 0.5},${block * HIGH + 0.5}${SHAPES[mode] ?? "v12"}`);
      svg.append(path);
    }),
  );
  return element("span", { class: "modes-holder" }, svg);
}

/** @param {string[]} phases */
const spoken = (phases) =>
  phases
    .map((phase) =>
      [...phase].map((mode, k) => (NAMES[mode] ? `${k + 1} ${NAMES[mode]}` : "or")).join(", "),
    )
    .join("; ");
