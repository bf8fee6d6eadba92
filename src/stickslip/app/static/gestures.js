/**
 * Pointer, wheel and keys on a plot: click, drag a box or a handle, zoom, reset, read.
 *
 * @import {Plot} from "./plot.js"
 * @import {Box} from "./types.js"
 */

const SLACK = 4; // pixels that a click may move
const DOUBLE_MS = 260;
const WALK = 100; // steps of the arrow keys over a plot

/** @param {Plot} plot */
export function attachGestures(plot) {
  const { over } = plot;
  /**
   * @type {{x: number, y: number, drag: ((x: number, y: number) => void) | null, moved: boolean} | null}
   */
  let press = null;
  let lastClick = 0;
  let waiting = 0;

  const place = (/** @type {MouseEvent} */ event) => {
    const box = over.getBoundingClientRect();
    return [(event.clientX - box.left) / plot.scale, (event.clientY - box.top) / plot.scale];
  };
  const inside = (/** @type {number} */ x, /** @type {number} */ y) =>
    x >= plot.left && x <= plot.right && y >= plot.top && y <= plot.bottom;

  over.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
    if (event.button !== 0) return;
    const [x, y] = place(event);
    if (!inside(x, y)) return;
    over.setPointerCapture(event.pointerId);
    press = { x, y, drag: plot.grab(x, y), moved: false };
    hideTip(plot);
  });

  over.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    const [x, y] = place(event);
    if (!press) {
      over.style.cursor = !inside(x, y) ? "" : plot.grab(x, y) ? "ew-resize" : "crosshair";
      return showTip(plot, x, y, inside(x, y) ? plot.onhover(plot.dataX(x), plot.dataY(y)) : null);
    }
    press.moved ||= Math.hypot(x - press.x, y - press.y) > SLACK;
    if (!press.moved) return;
    if (press.drag) press.drag(plot.dataX(clamp(x, plot.left, plot.right)), plot.dataY(y));
    else if (plot.onzoom) showBox(plot, press, x, y);
  });

  over.addEventListener("pointerup", (/** @type {PointerEvent} */ event) => {
    if (!press) return;
    const [x, y] = place(event);
    const { drag, moved, x: x0, y: y0 } = press;
    press = null;
    plot.box.hidden = true;
    if (moved && !drag && plot.onzoom) return zoomTo(plot, x0, y0, x, y);
    if (!moved) click(x, y);
  });
  over.addEventListener("pointercancel", () => {
    press = null;
    plot.box.hidden = true;
  });
  over.addEventListener("pointerleave", () => hideTip(plot));

  /** A click waits for its double, so that a reset does not start a motion as well. */
  function click(/** @type {number} */ x, /** @type {number} */ y) {
    const now = performance.now();
    clearTimeout(waiting);
    if (now - lastClick < DOUBLE_MS) {
      lastClick = 0;
      return plot.onreset();
    }
    lastClick = now;
    const [atX, atY] = [plot.dataX(x), plot.dataY(y)];
    waiting = setTimeout(() => plot.onclick(atX, atY), plot.onzoom ? DOUBLE_MS : 0);
  }

  over.addEventListener(
    "wheel",
    (/** @type {WheelEvent} */ event) => {
      const [x, y] = place(event);
      if (!plot.onzoom || !inside(x, y)) return;
      event.preventDefault();
      scale(plot, plot.dataX(x), plot.dataY(y), Math.exp(clamp(event.deltaY, -120, 120) * 0.002));
    },
    { passive: false },
  );

  over.addEventListener("blur", () => hideTip(plot));
  over.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (plot.held) return walk(plot, event, plot.held());
    if (!plot.onzoom) return;
    const [x0, x1, y0, y1] = plot.shown;
    const zoom = { "+": 1 / 1.5, "=": 1 / 1.5, "-": 1.5 }[event.key];
    const pan = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[
      event.key
    ];
    if (zoom) scale(plot, (x0 + x1) / 2, (y0 + y1) / 2, zoom);
    else if (pan) {
      const [dx, dy] = [0.1 * pan[0] * (x1 - x0), 0.1 * pan[1] * (y1 - y0)];
      plot.onzoom([x0 + dx, x1 + dx, y0 + dy, y1 + dy]);
    } else if (event.key === "0") plot.onreset();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
}

/** Along the horizontal axis, reading what is there. @param {Plot} plot @param {KeyboardEvent} event @param {number} from */
function walk(plot, event, from) {
  const [x0, x1, y0, y1] = plot.shown;
  const step = { ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10, Home: -WALK, End: WALK }[event.key];
  if (!step) return;
  const x = clamp(from + (step * (x1 - x0)) / WALK, x0, x1);
  plot.onclick(x, NaN);
  showTip(plot, plot.x(x), plot.y((y0 + y1) / 2), plot.onhover(x, NaN));
  event.preventDefault();
  event.stopPropagation();
}

const clamp = (/** @type {number} */ v, /** @type {number} */ low, /** @type {number} */ high) =>
  Math.min(high, Math.max(low, v));

/** @param {Plot} plot @param {number} cx @param {number} cy @param {number} factor */
function scale(plot, cx, cy, factor) {
  const [x0, x1, y0, y1] = plot.shown;
  const smallest = 1e-11 * Math.max(1, Math.abs(cx), Math.abs(cy));
  if (factor < 1 && Math.min(x1 - x0, y1 - y0) < smallest) return;
  plot.onzoom?.([
    cx + (x0 - cx) * factor,
    cx + (x1 - cx) * factor,
    cy + (y0 - cy) * factor,
    cy + (y1 - cy) * factor,
  ]);
}

/**
 * @param {Plot} plot
 * @param {number} ax
 * @param {number} ay
 * @param {number} bx
 * @param {number} by
 */
function zoomTo(plot, ax, ay, bx, by) {
  const [left, right] = [Math.min(ax, bx), Math.max(ax, bx)].map((x) =>
    clamp(x, plot.left, plot.right),
  );
  const [up, down] = [Math.min(ay, by), Math.max(ay, by)].map((y) =>
    clamp(y, plot.top, plot.bottom),
  );
  if (right - left < 2 * SLACK || (!plot.options.bare && down - up < 2 * SLACK)) return;
  const vertical = plot.options.bare
    ? [plot.shown[2], plot.shown[3]]
    : [plot.dataY(down), plot.dataY(up)];
  plot.onzoom?.(/** @type {Box} */ ([plot.dataX(left), plot.dataX(right), ...vertical]));
}

/** @param {Plot} plot @param {{x: number, y: number}} from @param {number} x @param {number} y */
function showBox(plot, from, x, y) {
  const [ax, bx] = [from.x, x].map((v) => clamp(v, plot.left, plot.right)).sort((a, b) => a - b);
  const [ay, by] = (plot.options.bare ? [plot.top, plot.bottom] : [from.y, y])
    .map((v) => clamp(v, plot.top, plot.bottom))
    .sort((a, b) => a - b);
  plot.box.hidden = false;
  Object.assign(plot.box.style, {
    left: `${ax * plot.scale}px`,
    top: `${ay * plot.scale}px`,
    width: `${(bx - ax) * plot.scale}px`,
    height: `${(by - ay) * plot.scale}px`,
  });
}

/** @param {Plot} plot @param {number} x @param {number} y @param {import("./plot.js").Tip} text */
function showTip(plot, x, y, text) {
  plot.tip.hidden = !text;
  if (!text) return;
  [x, y] = [x * plot.scale, y * plot.scale];
  plot.tip.replaceChildren(...[text].flat());
  const { offsetWidth: width, offsetHeight: height } = plot.tip;
  const left = x + 14 + width < plot.host.clientWidth ? x + 14 : Math.max(2, x - 14 - width);
  const top = clamp(y - height - 8, 2, Math.max(2, plot.host.clientHeight - height - 2));
  Object.assign(plot.tip.style, { left: `${left}px`, top: `${top}px` });
}

/** @param {Plot} plot */
function hideTip(plot) {
  plot.tip.hidden = true;
}
