/** Ticks at round values, numbers as text, search among sorted numbers. */

/**
 * @param {number} low @param {number} high
 * @param {number} count  about how many
 * @returns {{values: number[], labels: string[], offset: string}}
 *   `offset` is what has to be added to the labels, as text, or empty
 */
export function ticks(low, high, count) {
  const step = roundStep((high - low) / Math.max(1, count));
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  if (last <= first && high > low) return ticks(low, high, 2 * count); // one tells no scale
  const values = [];
  for (let k = first; k <= last && values.length < 50; k++) values.push(k * step);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const digits = Math.max(Math.abs(low), Math.abs(high)) / step;
  if (decimals > 5 && digits > 1e3) return deepLabels(values, step, (low + high) / 2);
  if (decimals > 5) return { values, labels: values.map((v) => short(v)), offset: "" };
  return { values, labels: values.map((v) => minus(fixed(v, decimals))), offset: "" };
}

/** Zoomed far in: labels count steps from a base. */
function deepLabels(
  /** @type {number[]} */ values,
  /** @type {number} */ step,
  /** @type {number} */ centre,
) {
  const unit = 10 ** Math.floor(Math.log10(step) + 1e-9);
  const base = Math.round(centre / (unit * 100)) * unit * 100;
  const labels = values.map((v) => minus(String(Math.round((v - base) / unit))));
  const decimals = Math.min(15, Math.max(0, Math.round(-Math.log10(unit * 100))));
  return {
    values,
    labels,
    offset: `×10${superscript(Math.round(Math.log10(unit)))} + ${minus(base.toFixed(decimals))}`,
  };
}

/** @param {number} rough */
function roundStep(rough) {
  const unit = 10 ** Math.floor(Math.log10(rough));
  const share = rough / unit;
  return unit * (share <= 1.1 ? 1 : share <= 2.2 ? 2 : share <= 5.5 ? 5 : 10);
}

const fixed = (/** @type {number} */ value, /** @type {number} */ decimals) => {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? (0).toFixed(decimals) : text;
};

const minus = (/** @type {string} */ text) => text.replace("-", "−");

const superscript = (/** @type {number} */ n) =>
  String(n)
    .replace("-", "⁻")
    .replace(/\d/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(digit)]);

/**
 * A number for reading, with so many digits.
 * @param {number | null | undefined} value @param {number} [digits]
 */
export function short(value, digits = 5) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const plain = Number(value.toPrecision(digits));
  const size = Math.abs(plain);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) {
    const [mantissa, exponent] = plain.toExponential().split("e");
    return `${minus(mantissa)}·10${superscript(Number(exponent))}`;
  }
  return minus(String(plain));
}

/** A range in few digits, its ends rounded inward. @param {number} low @param {number} high */
export function within(low, high) {
  const digits = 4 + Math.max(0, Math.floor(Math.log10(Math.max(-low, high) / (high - low))));
  return [low, high].map((end, k) => {
    const near = Number(end.toPrecision(digits));
    if (near >= low && near <= high) return near;
    const unit = 10 ** (Math.floor(Math.log10(Math.abs(end))) + 1 - digits);
    return Number((near + (k ? -unit : unit)).toPrecision(digits));
  });
}

/** A formula or a name as somebody typed it, in quotation marks. */
const QUOTED = /((?<!\w)'.*?'(?!\w)|"[^"]*")/;

/** A text changed, but for what is quoted in it. @param {string} text @param {(part: string) => string} change */
export const unquoted = (text, change) =>
  text
    .split(QUOTED)
    .map((part, k) => (k % 2 ? part : change(part)))
    .join("");

/** A text in which X_2 is X₂, A_3,1 A₃,₁, -0.1 −0.1, 40.0 40 and <= ≤. @param {string} text */
export const spelled = (text) => unquoted(text, typeset);

/** As Python prints it: 40.0, 1e-05. */
const NUMBER = /(?<![\w.])\d+(\.\d+)?(e[+-]?\d+)?(?!\w|\.\d)/g;

const typeset = (/** @type {string} */ text) =>
  text
    .replace(NUMBER, (text) => short(Number(text), 17))
    .replace(/->|<=|>=/g, (sign) => ({ "->": "→", "<=": "≤", ">=": "≥" })[sign] ?? sign)
    .replace(/(?<![\w.)\]])-(?=\.?\d|\()/g, "−")
    .replace(/_(\d+(?:,\d+)*)/g, (_, index) =>
      index.replace(/\d/g, (/** @type {string} */ digit) => "₀₁₂₃₄₅₆₇₈₉"[Number(digit)]),
    );

/** A symbol as it stands in texts. @param {string} symbol */
export const written = (symbol) => spelled(symbol.replace("V_dr", "V")).replace("_", "");

/** Texts as a list in a sentence. @param {string[]} texts */
export const listed = (texts) =>
  [texts.slice(0, -1).join(", "), ...texts.slice(-1)].filter(Boolean).join(" and ");

/** Least and greatest of all numbers in some lists. @param {Iterable<number>[]} lists @returns {[number, number]} */
export function span(...lists) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of lists)
    for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  return [low, high];
}

/**
 * Index of the nearest of sorted values.
 * @param {ArrayLike<number>} sorted
 * @param {number} value
 */
export function nearest(sorted, value) {
  let [low, high] = [0, sorted.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle;
    else high = middle;
  }
  return value - sorted[low] < sorted[high] - value ? low : high;
}

/**
 * Every `count`-th of a table's entries, from the k-th.
 * @param {ArrayLike<number>} values
 * @param {number} k
 * @param {number} count
 */
export const column = (values, k, count) =>
  Float64Array.from({ length: values.length / count }, (_, row) => values[row * count + k]);
