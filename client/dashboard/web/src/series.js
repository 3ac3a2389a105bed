// SPDX-License-Identifier: BSD-3-Clause
// What the probes have measured. The gateway keeps a history of bounded length, in which the extremes survive; what comes after it is added
// here, and when that is as much again, the history is asked for anew: so memory is bounded, however long the run.

/** Points of one probe that are kept before the history is asked for again. */
export const MOST = 8000;

/** @typedef {{name: string, unit: string, thinned: number, t: number[], v: (number|null)[]}} Probe */

export class Series {
  constructor() {
    /** @type {Map<string, Probe>} */
    this.probes = new Map();
    /** Is the history on its way? It is asked for once at a time. */
    this.coming = false;
    /** Which probes it has told of so far. @type {Set<string>} */
    this.told = new Set();
  }

  /** A piece of the history. What none of its pieces tells of is of another run. @param {{first: boolean, last: boolean, probes: Probe[]}} piece */
  recall({ first, last, probes }) {
    if (first) this.told.clear();
    for (const probe of probes) {
      this.probes.set(probe.name, probe);
      this.told.add(probe.name);
    }
    this.coming = !last;
    if (last) for (const name of this.probes.keys()) if (!this.told.has(name)) this.probes.delete(name);
  }

  clear() {
    this.probes.clear();
  }

  /**
   * Samples as they come; one that is not later than the last is of a new time line, which takes the place of the old one.
   * @param {string[]} names @param {string[]} units @param {(number|null)[][]} rows  time, then the values
   * @returns {boolean} whether the history should be asked for again; then it counts as coming
   */
  add(names, units, rows) {
    let full = false;
    for (const [time, ...values] of rows)
      names.forEach((name, k) => {
        let probe = this.probes.get(name);
        if (!probe) this.probes.set(name, probe = { name, unit: units[k], thinned: 0, t: [], v: [] });
        while (probe.t.length && probe.t[probe.t.length - 1] >= /** @type {number} */ (time)) {
          probe.t.pop();
          probe.v.pop();
        }
        probe.t.push(/** @type {number} */ (time));
        probe.v.push(values[k] ?? null);
        full ||= probe.t.length > MOST;
      });
    const ask = full && !this.coming;
    this.coming ||= ask;
    return ask;
  }
}
