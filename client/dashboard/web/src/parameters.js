// SPDX-License-Identifier: BSD-3-Clause
// What can be set while the run goes on: a slider where there are bounds, a list where there are words. Changes are collected and set
// together, all or none.
import { bounds, limits, shown } from "./format.js";

const DECADES = 3; // from so many on between its bounds, a slider is logarithmic

/** @typedef {{name: string, type: string, unit: string, range: string, value: string, meaning: string, takes_effect: string}} Parameter */

/**
 * How a slider of 1000 places stands for a number; null: no slider.
 * @param {Parameter} parameter
 * @returns {{to: (value: number) => number, from: (place: number) => number}|null}
 */
export function slide(parameter) {
  const { lo, hi, openLo, openHi } = bounds(parameter.range), whole = parameter.type === "whole number";
  if (lo === null || hi === null || !/number/.test(parameter.type)) return null;
  const logarithmic = lo > 0 && hi / lo >= 10 ** DECADES;
  const shape = logarithmic ? Math.log10 : (/** @type {number} */ x) => x, back = logarithmic ? (/** @type {number} */ x) => 10 ** x : (/** @type {number} */ x) => x;
  const a = shape(lo), b = shape(hi);
  return {
    to: (value) => Math.round(1000 * (shape(Math.min(Math.max(value, lo), hi)) - a) / (b - a)),
    from: (place) => {
      const at = Math.min(Math.max(place, openLo ? 1 : 0), openHi ? 999 : 1000), value = back(a + at / 1000 * (b - a));
      if (at === 0) return lo;
      if (at === 1000) return hi;
      if (whole) return Math.min(Math.max(Math.round(value), openLo ? lo + 1 : lo), openHi ? hi - 1 : hi);
      const round = Number(value.toPrecision(3));
      return round > lo && round < hi ? round : value;
    },
  };
}

/** Words that it may be, or null. @param {Parameter} parameter */
export function choices({ type }) {
  if (type === "true or false") return ["true", "false"];
  return /^[\w-]+(, [\w-]+)+$/.test(type) ? type.split(", ") : null;
}

/**
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag @param {object} properties @param {...(Node|string)} children @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  if (made.title) made.title = shown(made.title, true);
  made.append(...children.map((child) => typeof child === "string" ? shown(child, true) : child));
  return made;
}

export class Parameters {
  /** @param {HTMLElement} place @param {(settings: string[]) => Promise<boolean>} apply */
  constructor(place, apply) {
    this.place = place;
    /** @type {Map<string, string>} */
    this.changed = new Map();
    this.rows = element("div", { className: "rows" });
    this.applyButton = element("button", { className: "primary", disabled: true }, "Apply");
    this.revertButton = element("button", { disabled: true }, "Revert");
    this.form = element("form", {}, this.rows, element("div", { className: "foot" }, this.applyButton, this.revertButton));
    this.revertButton.type = "button";
    this.revertButton.onclick = () => this.revert();
    this.form.onsubmit = async (event) => {
      event.preventDefault();
      const settings = [...this.changed].map(([name, value]) => `${name}=${value}`);
      if (settings.length && await apply(settings)) this.revert();
    };
    this.place.append(this.form);
    /** @type {Parameter[]} */
    this.list = [];
  }

  revert() {
    this.changed.clear();
    this.show(this.list);
  }

  /** What the daemon has now; what is being changed here stays. @param {Parameter[]} list */
  show(list) {
    const focused = document.activeElement?.id;
    this.list = list;
    for (const name of this.changed.keys()) if (!list.some((p) => p.name === name)) this.changed.delete(name);
    this.rows.replaceChildren(...list.map((parameter) => this.row(parameter)));
    if (!list.length) this.rows.append(element("p", { className: "muted" }, "When a case is loaded, what can be changed is here."));
    if (focused) document.getElementById(focused)?.focus();
    this.count();
  }

  count() {
    const n = this.changed.size;
    this.applyButton.disabled = this.revertButton.disabled = !n;
    this.applyButton.textContent = n ? `Apply ${n} change${n > 1 ? "s" : ""}` : "Apply";
    this.form.classList.toggle("changed", n > 0);
  }

  /** @param {Parameter} parameter @param {HTMLElement} row @param {string} value */
  change(parameter, row, value) {
    if (value === parameter.value || value === "") this.changed.delete(parameter.name);
    else this.changed.set(parameter.name, value);
    row.classList.toggle("changed", this.changed.has(parameter.name));
    this.count();
  }

  /** @param {Parameter} parameter */
  row(parameter) {
    const { name, unit, range, meaning } = parameter, id = `set-${name}`;
    const now = this.changed.get(name) ?? parameter.value, { lo, hi } = bounds(range);
    const row = element("div", { className: "parameter" });
    const short = name.replace(/^scheme\.[a-z_]+\./, "");
    const called = short.replaceAll("_", " ").replace(".", ": "), label = element("label", { htmlFor: id, title: name }, called);
    const words = choices(parameter), sliding = slide(parameter);
    let input;
    if (words) {
      input = element("select", { id }, ...words.map((word) => element("option", { value: word, selected: word === now }, word)));
    } else if (/number/.test(parameter.type) && parameter.value !== "null") {
      input = element("input", { id, type: "number", step: parameter.type === "whole number" ? "1" : "any", value: now });
      if (lo !== null) input.min = String(lo);
      if (hi !== null) input.max = String(hi);
    } else input = element("input", { id, type: "text", value: now });
    const edit = element("div", { className: "edit" });
    if (sliding && !words) {
      const slider = element("input", { type: "range", min: "0", max: "1000", value: String(sliding.to(Number(now))), tabIndex: -1, ariaLabel: `${called}, slider` });
      const tell = () => { slider.ariaValueText = `${input.value} ${unit}`.trim(); }; // a thousandth of the way says nothing to who hears it
      slider.tabIndex = 0;
      slider.oninput = () => {
        input.value = String(sliding.from(Number(slider.value)));
        tell();
        this.change(parameter, row, input.value);
      };
      input.addEventListener("input", () => { slider.value = String(sliding.to(Number(input.value))); tell(); });
      tell();
      edit.append(slider);
    }
    input.addEventListener("input", () => this.change(parameter, row, input.value));
    edit.append(input, element("span", { className: "unit" }, unit));
    const allowed = limits(range);
    row.append(label, edit, element("p", { className: "muted" }, (allowed && `${allowed[0].toUpperCase()}${allowed.slice(1)}. `) + meaning));
    row.classList.toggle("changed", this.changed.has(name));
    return row;
  }
}
