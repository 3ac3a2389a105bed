// SPDX-License-Identifier: BSD-3-Clause
// What happened to a command, with what to do where it failed. A note goes when it is no longer so, and by itself unless somebody has to do
// something.
import { element } from "./parameters.js";
import { plain } from "./words.js";

const MOST = 4, GOOD_MS = 6000, BAD_MS = 30000;

export class Notes {
  /** @param {HTMLElement} place */
  constructor(place) {
    this.place = place;
  }

  /** @param {HTMLElement} note @param {string[]} about @param {number} patience  [ms], Infinity: until it is closed */
  put(note, about, patience) {
    const close = element("button", { className: "quiet", ariaLabel: "Close" }, "×");
    close.onclick = () => note.remove();
    note.append(close);
    note.dataset.about = about.join(" ");
    while (this.place.children.length >= MOST) this.place.firstElementChild?.remove();
    this.place.append(note);
    this.place.scrollTop = this.place.scrollHeight; // the newest is seen where there is no room for all
    const go = () => (note.matches(":hover, :focus-within") ? setTimeout(go, GOOD_MS) : note.remove()); // it is being read
    if (patience < Infinity) setTimeout(go, patience);
  }

  /** @param {string} text  "" for nothing: what is told of another command stays then, as its answer may have come just before @param {string} about  which command */
  tell(text, about) {
    this.settle(about);
    if (!text) return;
    this.place.querySelectorAll(".note:not(.bad)").forEach((note) => note.remove()); // what was before is over
    this.put(element("div", { className: "note", role: "status" }, element("div", {}, text)), [about], GOOD_MS);
  }

  /** @param {string} what @param {import("./words.js").Failure} error @param {string} about  which command */
  complain(what, error, about) {
    const { message, hint, path, lasting } = plain(error), twice = message.toLowerCase().startsWith(what.toLowerCase());
    const words = twice ? element("div", {}, element("b", {}, what), message.slice(what.length)) : element("div", {}, element("b", {}, `${what}: `), message);
    if (path) words.append(element("p", {}, `Entry: ${path}`));
    if (hint) words.append(element("p", {}, `What to do: ${hint}`));
    this.settle(about);
    this.put(element("div", { className: "note bad", role: "alert" }, words), [about, error.status ?? ""], lasting ? Infinity : BAD_MS);
  }

  /** What was said of this, a command or the status of a failure, is no longer so. @param {string} about */
  settle(about) {
    for (const note of /** @type {NodeListOf<HTMLElement>} */ (this.place.querySelectorAll(".note"))) if (note.dataset.about?.split(" ").includes(about)) note.remove();
  }

  /** Of a daemon that is gone only that stays which nobody knows: whether it did what it was told last. */
  begin() {
    for (const note of /** @type {NodeListOf<HTMLElement>} */ (this.place.querySelectorAll(".note"))) if (!note.dataset.about?.includes("unavailable")) note.remove();
  }
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
  if (document.activeElement instanceof HTMLInputElement) document.activeElement.select(); // who types replaces what is there
  return new Promise((resolve) => {
    dialog.onclose = () => resolve(dialog.returnValue === "yes" ? new FormData(form) : null);
  });
}
