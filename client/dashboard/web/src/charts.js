// SPDX-License-Identifier: BSD-3-Clause
// A small chart for each probe, by uPlot; only those in sight are drawn.
import uPlot from "uplot";
import { number } from "./format.js";

const HEIGHT = 120, EVERY_MS = 250;

/** What a chart shows from below to above: all values, with some air; a line in the middle if they are all the same. */
/** @returns {[number, number]} */
function height(/** @type {uPlot} */ _, /** @type {number|null} */ lo, /** @type {number|null} */ hi) {
  if (lo === null || hi === null) return [0, 1];
  const air = hi > lo ? 0.08 * (hi - lo) : Math.abs(lo) * 0.1 || 1;
  return [lo - air, hi + air];
}

export class Charts {
  /** @param {HTMLElement} place @param {import("./series.js").Series} series */
  constructor(place, series) {
    this.place = place;
    this.series = series;
    /** @type {Map<string, {figure: HTMLElement, value: HTMLElement, plot: uPlot, inSight: boolean, thinned: HTMLElement}>} */
    this.charts = new Map();
    this.sight = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        const chart = this.charts.get(/** @type {HTMLElement} */ (entry.target).dataset.probe ?? "");
        if (chart) chart.inSight = entry.isIntersecting;
      }
      this.stale = true;
    });
    this.sync = uPlot.sync("probes");
    this.stale = true;
    this.drawn = 0;
    this.none = document.createElement("p");
    this.none.className = "muted";
    this.none.textContent = "Probes of the case are drawn here as they are sampled.";
    new ResizeObserver(() => this.fit()).observe(place);
  }

  /** After another theme, or another case. */
  rebuild() {
    for (const { plot } of this.charts.values()) plot.destroy();
    this.sight.disconnect();
    this.charts.clear();
    this.place.replaceChildren();
    this.stale = true;
  }

  fit() {
    const width = this.width();
    if (width > 0) for (const { plot } of this.charts.values()) plot.setSize({ width, height: HEIGHT });
  }

  width() {
    const two = this.place.clientWidth > 760;
    return Math.floor((this.place.clientWidth - (two ? 44 : 32)) / (two ? 2 : 1));
  }

  /** @param {import("./series.js").Probe} probe */
  make(probe) {
    const style = getComputedStyle(document.body), ink = style.getPropertyValue("--muted"), line = style.getPropertyValue("--line");
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    const name = document.createElement("b"), value = document.createElement("span"), thinned = document.createElement("small");
    figure.dataset.probe = probe.name;
    name.textContent = probe.name;
    value.className = "value";
    thinned.className = "muted";
    caption.append(name, thinned, value);
    figure.append(caption);
    this.place.append(figure);
    const axis = { stroke: ink, grid: { stroke: line, width: 1 }, ticks: { stroke: line, size: 4 }, font: "11px system-ui, sans-serif" };
    const values = (/** @type {uPlot} */ _, /** @type {number[]} */ splits) => splits.map((v) => number(v, 5));
    const plot = new uPlot({
      width: Math.max(100, this.width()), height: HEIGHT, legend: { show: false },
      cursor: { sync: { key: this.sync.key }, y: false, drag: { x: false, y: false } },
      scales: { x: { time: false }, y: { range: height } },
      series: [{}, { stroke: style.getPropertyValue("--accent"), width: 1.5, points: { show: false } }],
      axes: [{ ...axis, size: 26, values: (_, s) => s.map((v, k) => (k === s.length - 1 ? `${number(v, 5)} s` : number(v, 5))) },
        { ...axis, size: 64, space: 28, values }],
      hooks: { setCursor: [(u) => this.showValue(probe.name, u.cursor.idx)] },
    }, [[], []], figure);
    const chart = { figure, value, plot, inSight: true, thinned };
    this.charts.set(probe.name, chart);
    this.sight.observe(figure);
    return chart;
  }

  /** @param {string} name @param {number|null|undefined} at  index below the pointer; none: the latest */
  showValue(name, at) {
    const probe = this.series.probes.get(name), chart = this.charts.get(name);
    if (!probe || !chart) return;
    const k = at ?? probe.t.length - 1;
    const when = at === null || at === undefined ? "" : ` at ${number(probe.t[k], 5)} s`;
    chart.value.textContent = `${number(probe.v[k], 5)} ${probe.unit === "1" ? "" : probe.unit}${when}`;
  }

  /** Draw what has changed, at most a few times a second. @param {number} now [ms] */
  draw(now) {
    if (!this.stale || now - this.drawn < EVERY_MS || !this.place.clientWidth) return;
    this.stale = false;
    this.drawn = now;
    for (const probe of this.series.probes.values()) {
      const chart = this.charts.get(probe.name) ?? this.make(probe);
      if (!chart.inSight) continue;
      // Of a single point uPlot would make an axis of its own.
      chart.plot.setData(probe.t.length === 1 ? [[probe.t[0], probe.t[0] + 1], [probe.v[0], null]] : [probe.t, probe.v]);
      chart.thinned.textContent = probe.thinned ? "thinned, extremes kept" : "";
      this.showValue(probe.name, chart.plot.cursor.idx);
    }
    if (this.series.probes.size) this.none.remove();
    else this.place.append(this.none);
    for (const [name, { figure, plot }] of this.charts)
      if (!this.series.probes.has(name)) {
        plot.destroy();
        figure.remove();
        this.charts.delete(name);
      }
  }
}
