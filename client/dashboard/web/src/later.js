// SPDX-License-Identifier: BSD-3-Clause
// What is to happen at a later step or time: asked for in a dialog, listed, and called off.
import { count, number } from "./format.js";
import { confirmed } from "./notes.js";
import { element } from "./parameters.js";

/** @typedef {{id: string, at_step: number|null, at_time: number|null, who: string, what: string}} Scheduled */

/**
 * The message for the gateway; a change has one "path=value" on each line.
 * @param {FormData} form @returns {{do: string, settings?: string[], at_step?: number, at_time?: number}}
 */
export function appointment(form) {
  const what = String(form.get("what")), at = Number(form.get("at")), when = form.get("unit") === "step" ? { at_step: at } : { at_time: at };
  const lines = String(form.get("settings") ?? "").split("\n").map((line) => line.trim()).filter(Boolean);
  return { do: what, ...(what === "set" ? { settings: lines } : {}), ...when };
}

/** The daemon's words have the time in them, unless they are cut. @param {Scheduled} one */
export function told(one) {
  if (/, at (step \d+|t = \S+ s)$/.test(one.what)) return one.what;
  return `${one.what}, ${one.at_step === null ? `at t = ${number(one.at_time, 6)} s` : `at step ${count(one.at_step)}`}`;
}

/** Ask what, and when. @param {HTMLDialogElement} dialog @param {number} time  now, simulated @returns {Promise<FormData|null>} */
export function askLater(dialog, time) {
  const what = element("select", { name: "what", ariaLabel: "What" },
    ...[["pause", "Pause"], ["snapshot", "Write a snapshot"], ["checkpoint", "Write a checkpoint"], ["set", "Change parameters"]].map(([value, text]) => element("option", { value }, text)));
  const settings = element("textarea", { name: "settings", rows: 2, placeholder: "gravity=[0, -2]", ariaLabel: "Changes, one on each line", hidden: true });
  what.onchange = () => {
    settings.hidden = what.value !== "set";
    settings.required = !settings.hidden;
  };
  const at = element("input", { name: "at", type: "number", min: "0", step: "any", required: true, placeholder: number(time, 4), ariaLabel: "When" });
  const unit = element("select", { name: "unit", ariaLabel: "Of what" }, element("option", { value: "time" }, "s (simulated)"), element("option", { value: "step" }, "step"));
  unit.onchange = () => {
    at.step = unit.value === "step" ? "1" : "any";
    at.placeholder = unit.value === "step" ? "" : number(time, 4);
  };
  return confirmed(dialog, "Later", "It takes effect when the run is there, exactly; nothing is set in motion by it.", "Schedule it",
    element("p", { className: "later" }, what, " at ", at, unit), settings);
}

/** List what is scheduled. @param {HTMLElement} place @param {Scheduled[]} list @param {(one: Scheduled) => void} callOff */
export function showLater(place, list, callOff) {
  const key = JSON.stringify(list);
  if (place.dataset.key === key) return;
  place.dataset.key = key;
  place.hidden = !list.length;
  place.replaceChildren(...list.map((one) => {
    const off = element("button", { className: "quiet", ariaLabel: `Call off: ${told(one)}`, title: "Call it off" }, "×");
    off.onclick = () => callOff(one);
    return element("span", { title: `asked for by ${one.who}` }, told(one), off);
  }));
}
