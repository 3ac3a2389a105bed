// SPDX-License-Identifier: BSD-3-Clause
// What happened to a command: failures stay until they are read, with what to do; successes go away by themselves.
import { element } from "./parameters.js";

const MOST = 4, GOOD_MS = 6000;

/** @param {HTMLElement} place @param {HTMLElement} note @param {boolean} bad */
function put(place, note, bad) {
  const close = element("button", { className: "quiet", ariaLabel: "Close" }, "×");
  close.onclick = () => note.remove();
  note.append(close);
  while (place.children.length >= MOST) place.firstElementChild?.remove();
  place.append(note);
  if (!bad) setTimeout(() => note.remove(), GOOD_MS);
}

/** @param {HTMLElement} place @param {string} text  "": it is plain to see */
export function tell(place, text) {
  place.replaceChildren(); // what was before is over
  if (text) put(place, element("div", { className: "note", role: "status" }, element("div", {}, text)), false);
}

/** @param {HTMLElement} place @param {string} what @param {{message: string, hint?: string, path?: string}} error */
export function complain(place, what, error) {
  const words = element("div", {}, element("b", {}, `${what}: `), error.message);
  if (error.path && !error.message.includes(error.path)) words.append(element("p", {}, `Entry: ${error.path}`));
  if (error.hint) words.append(element("p", {}, `What to do: ${error.hint}`));
  put(place, element("div", { className: "note bad", role: "alert" }, words), true);
}

/** Ask before something that cannot be taken back. @returns {Promise<FormData|null>} null: better not */
export function confirmed(/** @type {HTMLDialogElement} */ dialog, /** @type {string} */ title, /** @type {string} */ text, /** @type {string} */ yes, /** @type {Node[]} */ ...more) {
  const cancel = element("button", { type: "button" }, "Cancel"); // no submit button, so that Enter means yes
  cancel.onclick = () => dialog.close("");
  const form = element("form", { method: "dialog" }, element("h2", {}, title), element("p", {}, text), ...more,
    element("div", { className: "actions" }, cancel, element("button", { className: "primary", value: "yes" }, yes)));
  dialog.replaceChildren(form);
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.onclose = () => resolve(dialog.returnValue === "yes" ? new FormData(form) : null);
  });
}
