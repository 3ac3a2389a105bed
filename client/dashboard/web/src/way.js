// SPDX-License-Identifier: BSD-3-Clause
// How fast a run comes back after a crash. The daemon says at which step it is, and to which it goes.

const WINDOW_S = 10, LEAST_S = 1;

export class Way {
  constructor() {
    /** @type {{at: number, step: number}[]} */
    this.seen = [];
  }

  /** @param {number} at  wall clock [s] @param {number} step */
  note(at, step) {
    if (this.seen.length && step < this.seen[this.seen.length - 1].step) this.seen = [];
    this.seen.push({ at, step });
    while (this.seen.length > 2 && this.seen[1].at <= at - WINDOW_S) this.seen.shift();
  }

  /** Steps in a second, of the last ones; null: not known yet. */
  rate() {
    const first = this.seen[0], last = this.seen[this.seen.length - 1];
    return first && last.at - first.at >= LEAST_S && last.step > first.step ? (last.step - first.step) / (last.at - first.at) : null;
  }

  /** How long yet [s]; null: not known. @param {number} goal */
  left(goal) {
    const rate = this.rate();
    return rate === null ? null : Math.max(0, goal - this.seen[this.seen.length - 1].step) / rate;
  }
}
