// SPDX-License-Identifier: BSD-3-Clause
// The ends of the colour bar: what most values lie between, so that one spray particle does not grey out the picture, and calm from picture
// to picture.

const SAMPLE = 4000, TAIL = 0.01, EASE = 0.2;

/**
 * The values between which all but the lowest and highest hundredth lie, of an even sample.
 * @param {Float32Array} values
 * @param {(k: number) => boolean} counts  whether the value of this particle counts
 * @returns {[number, number]|null}
 */
export function spread(values, counts = () => true) {
  const stride = Math.max(1, Math.floor(values.length / SAMPLE)), list = [];
  for (let k = 0; k < values.length; k += stride) if (Number.isFinite(values[k]) && counts(k)) list.push(values[k]);
  if (!list.length) return null;
  list.sort((a, b) => a - b);
  const tail = Math.floor(TAIL * list.length);
  return [list[tail], list[list.length - 1 - tail]];
}

/** Follows the spread of one field; new ends at once when it begins or must be begun again. */
export class Range {
  constructor() {
    /** @type {[number, number]|null} */
    this.ends = null;
    this.held = false;
  }

  begin() {
    this.ends = null;
  }

  /** @param {[number, number]|null} wanted @param {boolean} symmetric  the middle of the map means zero */
  follow(wanted, symmetric = false) {
    if (!wanted || (this.held && this.ends)) return this.ends;
    let [lo, hi] = wanted;
    if (symmetric) [lo, hi] = [-Math.max(Math.abs(lo), Math.abs(hi)), Math.max(Math.abs(lo), Math.abs(hi))];
    if (!(hi > lo)) [lo, hi] = [lo - (Math.abs(lo) / 20 || 1), hi + (Math.abs(hi) / 20 || 1)];
    if (!this.ends) this.ends = [lo, hi];
    else this.ends = [this.ends[0] + EASE * (lo - this.ends[0]), this.ends[1] + EASE * (hi - this.ends[1])];
    return this.ends;
  }
}
