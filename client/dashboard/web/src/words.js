// SPDX-License-Identifier: BSD-3-Clause
// What a failure is called here. The daemon's sentences and hints are for a shell too; here there are buttons.
import { count, number } from "./format.js";

/** @typedef {{status?: string, message: string, hint?: string, path?: string}} Failure */

/** What to do here; all else is as the gateway says it. @type {Record<string, string>} */
const HINTS = {
  held: "wait until it is given back, then try again; Pause, Stop, Snapshot and Checkpoint are possible all the same",
  expired: "see above who holds it now; if nobody does, press Take the lease",
  "not found": "check the name; the message may say what there is",
  "wrong state": "see above what the run does; buttons are grey where they are of no use, and say why",
  "timed out": "see below how far it is",
  interrupted: "",
  diverged: "see above what is possible now",
};
/** Says no more than the message does. */
const NOTHING_MORE = "mend what the message names and try again";
/** Those that wait for somebody to do something; others say little after a while. */
const LASTING = ["expired", "no space", "input/output error", "out of memory", "unavailable", "internal error"];

/** @param {Failure} error @returns {{message: string, hint: string, path: string, lasting: boolean}} */
export function plain(error) {
  const { status = "", message, hint = "", path = "" } = error;
  const isWhen = path === "at_time" || path === "at_step", isLease = status === "held" || status === "expired";
  const holder = status === "held" && /^.* holds the lease for another [\d.]+ s/s.exec(message)?.[0];
  return {
    message: holder ? `${holder}; nothing was done` : message, hint: HINTS[status] ?? (hint === NOTHING_MORE ? "" : hint),
    path: isWhen || isLease || !path || message.includes(path) ? "" : path, lasting: LASTING.includes(status),
  };
}

/**
 * Of a run in FAULT: whether its state is none to go on from, and what to do. A formula or a file can be mended, and then it resumes.
 * @param {{fault?: string|null, fault_reason?: string|null, can_restore?: boolean|null}} status @returns {{broken: boolean, hint: string}}
 */
export function trouble({ fault, fault_reason, can_restore }) {
  if (["diverged", "limit reached", "out of memory"].includes(fault_reason ?? ""))
    return { broken: true, hint: `look at it, write a snapshot; then press Go back${can_restore === false ? ", to the beginning, as there is no checkpoint" : ", to the newest checkpoint or to the beginning"}` };
  if (fault_reason !== "invalid") return { broken: false, hint: "see to what is said, then press Resume" };
  return { broken: false, hint: fault?.startsWith("gravity") ? "set another gravity under Parameters, then press Resume" : "write a checkpoint or a snapshot of what there is; then press Stop, and load a case with another formula" };
}

/** As a sentence, to which others can be added. @param {string} text */
export function sentence(text) {
  return !text || /[.!?]$/.test(text) ? text : `${text}.`;
}

/**
 * What was ended on request is no failure.
 * @param {Failure} error @param {{step?: number, time?: number|null, state?: string}} where  it ended @param {number} from  the step at which it began
 * @param {number} [goal]  the time that it was to run to
 */
export function brokenOff(error, { step, time, state }, from, goal) {
  const why = error.message.replace(/ on request$/, "");
  if (step === undefined || step < from || state === "EMPTY") return `Ended: ${why}`;
  if (goal !== undefined) return `Stopped at t = ${number(time, 6)} s, before ${number(goal, 6)} s: ${why}`;
  return `Stopped after ${count(step - from)} ${step - from === 1 ? "step" : "steps"}: ${why}`;
}
