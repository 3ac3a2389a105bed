// SPDX-License-Identifier: BSD-3-Clause
// What has happened: events as they come, and the journal of the run.
import { element } from "./parameters.js";
import { count, number } from "./format.js";

const MOST_EVENTS = 500, MOST_RECORDS = 500;

/** @param {string} text  a time of day in UTC, as JSON has it */
function clock(text) {
  const when = new Date(text);
  return Number.isNaN(when.getTime()) ? "" : when.toLocaleTimeString([], { hour12: false });
}

/** @param {string} text  the same, with the day */
function moment(text) {
  const when = new Date(text);
  return Number.isNaN(when.getTime()) ? "" : when.toLocaleString([], { hour12: false });
}

/**
 * What happened, for people: nothing twice, and of files of the run their names.
 * @param {any} message  an event or a line of the log @param {string} [directory]  of the run
 */
export function story({ topic, what, text }, directory) {
  const said = text || what || "", here = directory ? said.replaceAll(`${directory}/`, "") : said;
  if (topic === "log") return here;
  const whole = what && text && !text.startsWith(what) ? `${what}: ${here}` : here;
  return whole.charAt(0).toUpperCase() + whole.slice(1);
}

/** @param {string[]} names @param {string[]} classes */
function head(names, classes) {
  return element("thead", {}, element("tr", {}, ...names.map((name, k) => element("th", { className: classes[k], scope: "col" }, name))));
}

export class Events {
  /** @param {HTMLElement} place @param {() => string|undefined} directory  of the run */
  constructor(place, directory) {
    this.directory = directory;
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
    const row = element("tr", { className: message.topic === "log" && message.level <= 4 || message.state === "FAULT" ? "bad" : "" },
      element("td", { className: "narrow", title: message.when ? moment(message.when) : "Before the dashboard was started" }, message.when ? clock(message.when) : "earlier"),
      element("td", { className: "narrow number" }, number(message.time, 5)), element("td", { title: message.text || message.what }, story(message, this.directory())));
    this.body.prepend(row);
    while (this.body.children.length > MOST_EVENTS) this.body.lastElementChild?.remove();
    this.table.hidden = false;
    this.none.hidden = true;
  }
}

/** What a record asked for. @param {any} record */
export function order(record) {
  if (record.kind === "halted") return "came to stand by itself";
  return [(record.command ?? "").replaceAll("_", " "), record.arguments ?? ""].join(" ").trim();
}

/** What became of it. @param {any} record */
export function deed(record) {
  const changes = (record.changes ?? []).map((/** @type {any} */ c) => `${c.path}: ${c.before} → ${c.after}`);
  if (record.kind === "begun") return "begun";
  if (record.kind === "halted") return record.state;
  if (record.kind === "scheduled") return `scheduled for ${record.at_step !== null ? `step ${count(record.at_step)}` : `t = ${number(record.at_time, 6)} s`}`;
  if (changes.length) return changes.join("; ");
  const { code, message, state } = record.reply ?? {};
  if (code && code !== "OK") return message || code;
  return state ?? "";
}

/** The commands of a run. It is read again while somebody sees it, and those rows stay which are there already. */
export class Journal {
  /** @param {HTMLElement} place @param {() => Promise<any>} ask */
  constructor(place, ask) {
    this.place = place;
    this.ask = ask;
    /** @type {number|null|undefined} */
    this.size = undefined;
    this.reading = false;
    this.rest = 0; // [ms] until which it is left alone: a long journal takes a while, and others want the processor too
    /** @type {Map<string, HTMLElement>} */
    this.rows = new Map();
    this.text = element("p", { className: "muted" }, "");
    this.body = element("tbody");
    this.table = element("table", { hidden: true }, head(["Time", "Step", "Command", "Outcome"], ["narrow", "narrow number", "", ""]), this.body);
    place.append(element("div", { className: "panel-head" }, this.text), this.table);
  }

  /** Read what is new in it, if there is somebody to see it. @param {number|null|undefined} size  of its file [bytes] */
  async follow(size) {
    if (this.place.hidden || document.hidden || this.reading || size === this.size || performance.now() < this.rest) return;
    const began = performance.now();
    this.reading = true;
    this.size = size;
    const answer = await this.ask();
    this.show(answer);
    this.reading = false;
    if (answer.error?.status === "unsent" || answer.error?.status === "unavailable") this.size = undefined; // nobody has been asked
    this.rest = performance.now() + 4 * (performance.now() - began);
  }

  /** Whoever begins to look sees the newest of it. @param {number|null|undefined} size */
  open(size) {
    this.size = undefined;
    this.rest = 0;
    this.follow(size ?? null);
  }

  /** @param {any} answer */
  show(answer) {
    this.table.hidden = Boolean(answer.error) || !answer.records?.length;
    if (answer.error) {
      this.text.textContent = answer.error.message + (answer.error.hint ? ` (${answer.error.hint})` : "");
      return;
    }
    this.text.textContent = "Every command that changed the run, newest first: what came of it, or the state after it."
      + (answer.records.length >= MOST_RECORDS ? ` Here are the last ${count(MOST_RECORDS)}; meniscus log prints all.` : "");
    const rows = new Map();
    for (const record of [...answer.records].reverse()) {
      const key = JSON.stringify(record);
      rows.set(key, this.rows.get(key) ?? this.row(record));
    }
    this.rows = rows;
    this.put([...rows.values()]);
  }

  /** Who reads farther down goes on reading there. @param {HTMLElement[]} rows  the newest first */
  put(rows) {
    const kept = new Set(/** @type {Element[]} */ (rows)), there = [...this.body.children], top = this.place.getBoundingClientRect().top;
    const read = this.place.scrollTop > 0 ? there.find((row) => kept.has(row) && row.getBoundingClientRect().bottom > top) : undefined;
    const before = read?.getBoundingClientRect().top ?? 0;
    for (const row of there) if (!kept.has(row)) row.remove();
    rows.forEach((row, k) => this.body.children[k] === row || this.body.insertBefore(row, this.body.children[k] ?? null));
    if (read) this.place.scrollTop += read.getBoundingClientRect().top - before;
  }

  /** @param {any} record */
  row(record) {
    const bad = record.reply && record.reply.code !== "OK" && record.reply.code !== "ABORTED"; // that was asked for
    return element("tr", { className: bad ? "bad" : "" },
      element("td", { className: "narrow", title: moment(record.when) }, clock(record.when)), element("td", { className: "narrow number" }, String(record.step)),
      element("td", { title: record.who ? `By ${record.who}` : "" }, order(record)), element("td", {}, deed(record)));
  }
}
