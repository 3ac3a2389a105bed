// SPDX-License-Identifier: BSD-3-Clause
// What has happened: events as they come, and the journal of the run.
import { element } from "./parameters.js";
import { number } from "./format.js";

const MOST_EVENTS = 500;

/** @param {string} text  a time of day in UTC, as JSON has it */
function clock(text) {
  const when = new Date(text);
  return Number.isNaN(when.getTime()) ? "" : when.toLocaleTimeString([], { hour12: false });
}

/** @param {string[]} names @param {string[]} classes */
function head(names, classes) {
  return element("thead", {}, element("tr", {}, ...names.map((name, k) => element("th", { className: classes[k], scope: "col" }, name))));
}

export class Events {
  /** @param {HTMLElement} place */
  constructor(place) {
    this.body = element("tbody");
    this.none = element("p", { className: "muted" }, "Nothing has happened yet. Changes of state, settings and warnings are listed here, newest first.");
    this.table = element("table", { hidden: true }, head(["Time", "t (s)", "What"], ["narrow", "narrow number", ""]), this.body);
    place.append(this.none, this.table);
  }

  clear() {
    this.body.replaceChildren();
    this.table.hidden = true;
    this.none.hidden = false;
  }

  /** @param {any} message  an event or a line of the log */
  add(message) {
    const what = message.topic === "log" ? message.text : message.text || message.what;
    const row = element("tr", { className: message.topic === "log" && message.level <= 4 || message.state === "FAULT" ? "bad" : "" },
      element("td", { className: "narrow" }, message.when ? clock(message.when) : "before"), element("td", { className: "narrow number" }, number(message.time, 5)),
      element("td", {}, message.topic === "event" && message.what && message.text ? `${message.what}: ${message.text}` : what));
    this.body.prepend(row);
    while (this.body.children.length > MOST_EVENTS) this.body.lastElementChild?.remove();
    this.table.hidden = false;
    this.none.hidden = true;
  }
}

/** What a record changed, in words. @param {any} record */
export function deed(record) {
  const changes = (record.changes ?? []).map((/** @type {any} */ c) => `${c.path}: ${c.before} → ${c.after}`);
  if (record.kind === "begun") return "set out";
  if (changes.length) return changes.join("; ");
  const { code, message, state } = record.reply ?? {};
  if (code && code !== "OK") return `${code}: ${message ?? ""}`;
  return state ?? "";
}

export class Journal {
  /** @param {HTMLElement} place @param {() => Promise<any>} ask */
  constructor(place, ask) {
    this.ask = ask;
    this.text = element("p", { className: "muted" }, "");
    const again = element("button", {}, "Read again");
    again.onclick = () => this.read();
    this.body = element("tbody");
    this.table = element("table", { hidden: true }, head(["When", "Step", "Command", "What"], ["narrow", "narrow number", "narrow", ""]), this.body);
    place.append(element("div", { className: "panel-head" }, this.text, element("span", { className: "gap" }), again), this.table);
  }

  async read() {
    const answer = await this.ask();
    this.table.hidden = Boolean(answer.error) || !answer.records?.length;
    if (answer.error) {
      this.text.textContent = answer.error.message + (answer.error.hint ? ` (${answer.error.hint})` : "");
      return;
    }
    const records = [...answer.records].reverse();
    this.text.textContent = `The last ${records.length} of ${answer.n_records} records, newest first; hashes of the state are left out.`;
    this.body.replaceChildren(...records.map((record) => element("tr", { className: record.reply && record.reply.code !== "OK" ? "bad" : "" },
      element("td", { className: "narrow", title: record.when }, clock(record.when)), element("td", { className: "narrow number" }, String(record.step)),
      element("td", { className: "narrow", title: record.who ?? "" }, record.command ?? ""), element("td", {}, deed(record)))));
  }
}
