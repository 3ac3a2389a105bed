// SPDX-License-Identifier: BSD-3-Clause
// Numbers, durations and ranges as people read them.

/** A number with so many significant digits, without a tail of zeros. @param {number|null|undefined} value */
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(Math.max(0, digits - 1)).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}

/** A count with thin spaces between thousands. @param {number} value */
export function count(value) {
  return String(Math.round(value)).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
}

/** Wall-clock time to go. @param {number|null|undefined} seconds */
export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  const s = Math.max(0, Math.round(seconds));
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min ${s % 60} s`;
  if (s < 86400) return `${Math.floor(s / 3600)} h ${Math.floor(s % 3600 / 60)} min`;
  return `${Math.floor(s / 86400)} d ${Math.floor(s % 86400 / 3600)} h`;
}

/**
 * Round numbers between lo and hi, about n of them.
 * @param {number} lo @param {number} hi @param {number} n @returns {number[]}
 */
export function ticks(lo, hi, n) {
  if (!(hi > lo) || !(n >= 1)) return [];
  const rough = (hi - lo) / n, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough) ?? 10 * power;
  const list = [];
  for (let k = Math.ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * step; k++) list.push(Number((k * step).toPrecision(12)));
  return list;
}

/**
 * Bounds as capabilities say them: "[0, 1]", "(0, inf)"; null where there is none.
 * @param {string} text @returns {{lo: number|null, hi: number|null, openLo: boolean, openHi: boolean}}
 */
export function bounds(text) {
  const found = /^([[(])\s*([^,\s]+)\s*,\s*([^\])\s]+)\s*([\])])$/.exec(text ?? "");
  if (!found) return { lo: null, hi: null, openLo: false, openHi: false };
  const end = (/** @type {string} */ word) => (Number.isFinite(Number(word)) ? Number(word) : null);
  return { lo: end(found[2]), hi: end(found[3]), openLo: found[1] === "(", openHi: found[4] === ")" };
}

/** The same in words; "" where there are none. @param {string} text */
export function limits(text) {
  const { lo, hi, openLo, openHi } = bounds(text);
  if (lo === null) return hi === null ? "" : `${openHi ? "below" : "up to"} ${number(hi)}`;
  if (hi === null) return openLo ? `above ${number(lo)}` : `${number(lo)} or more`;
  return openLo ? `above ${number(lo)}, ${openHi ? "below" : "up to"} ${number(hi)}` : `${number(lo)} to ${openHi ? "below " : ""}${number(hi)}`;
}

/** A vector as the case writes it: "[0, -1]"; numbers only. @param {string} text @returns {number[]} */
export function vector(text) {
  const inside = /^\[(.+)\]$/.exec(text ?? "")?.[1];
  return inside ? inside.split(",").map(Number).filter(Number.isFinite) : [];
}

/**
 * A text that comes from a case or a client, with \uXXXX for what cannot be seen or turns around what is beside it: the rule is that of common/host/text.c.
 * @param {string} text @param {boolean} [lines]  newlines and tabs stay
 */
export function shown(text, lines = false) {
  return text.replace(/[\p{Cc}\p{Default_Ignorable_Code_Point}\u2028\u2029\ufff9-\ufffb]/gu, (character) => {
    if (character === "\n" || character === "\t") return lines ? character : character === "\n" ? "\\n" : "\\t";
    return Array.from({ length: character.length }, (_, k) => `\\u${character.charCodeAt(k).toString(16).padStart(4, "0")}`).join("");
  });
}
