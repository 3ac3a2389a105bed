// SPDX-License-Identifier: BSD-3-Clause
// What needs no browser: numbers, ranges, pictures as they come, the past of the probes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { distanceToFit } from "../src/fit.js";
import { bounds, count, duration, limits, number, shown, ticks, vector } from "../src/format.js";
import { decode } from "../src/frame.js";
import { appointment, told } from "../src/later.js";
import { patience } from "../src/link.js";
import { deed, order, story } from "../src/logs.js";
import { choices, slide } from "../src/parameters.js";
import { Range, spread } from "../src/range.js";
import { MOST, Series } from "../src/series.js";
import { Way } from "../src/way.js";
import { brokenOff, plain, sentence, trouble } from "../src/words.js";

/** As the gateway makes them. */
function picture(/** @type {object} */ header, /** @type {number[]} */ floats, /** @type {number[]} */ bytes, skipped = 0) {
  const text = new TextEncoder().encode(JSON.stringify(header)), padded = Math.ceil(text.length / 4) * 4;
  const buffer = new ArrayBuffer(8 + padded + 4 * floats.length + bytes.length), view = new DataView(buffer);
  view.setUint32(0, padded, true);
  view.setUint32(4, skipped, true);
  new Uint8Array(buffer, 8, padded).fill(32).set(text);
  new Float32Array(buffer, 8 + padded, floats.length).set(floats);
  new Uint8Array(buffer, 8 + padded + 4 * floats.length).set(bytes);
  return buffer;
}

test("a picture is read as it was written", () => {
  const frame = decode(picture({ particles: 2, dimensions: 2, field: "pressure", unit: "Pa" }, [1, 2, 3, 4, 10, 20], [0, 1], 7));
  assert.deepEqual([...frame.position], [1, 2, 3, 4]);
  assert.deepEqual([...frame.value ?? []], [10, 20]);
  assert.deepEqual([...frame.phase], [0, 1]);
  assert.equal(frame.skipped, 7);
  assert.equal(frame.unit, "Pa");
});

test("a picture by phase has no values", () => {
  const frame = decode(picture({ particles: 1, dimensions: 3, field: "phase" }, [1, 2, 3], [5]));
  assert.equal(frame.value, null);
  assert.deepEqual([...frame.phase], [5]);
});

test("a picture of another size than it says is refused", () => {
  const good = picture({ particles: 2, dimensions: 2, field: "phase" }, [1, 2, 3, 4], [0, 1]);
  for (const size of [0, 7, 12, good.byteLength - 1]) assert.throws(() => decode(good.slice(0, size)));
  assert.throws(() => decode(picture({ particles: 3, dimensions: 2, field: "phase" }, [1, 2, 3, 4], [0, 1])), /another size/);
});

test("numbers are short, and what is not known is a dash", () => {
  assert.deepEqual([0, 1234.5678, -0.00001234, 2.5e9, 1e-9, 1e6].map((v) => number(v)), ["0", "1235", "-1.234e-5", "2.5e9", "1e-9", "1e6"]);
  assert.deepEqual([null, undefined, NaN, Infinity].map((v) => number(v)), ["–", "–", "–", "–"]);
  assert.equal(count(1234567), "1\u202f234\u202f567");
  assert.equal(count(999), "999");
});

test("durations are in the units that people would say", () => {
  assert.deepEqual([0, 59.4, 61, 3600, 90000, null].map((s) => duration(s)), ["0 s", "59 s", "1 min 1 s", "1 h 0 min", "1 d 1 h", "–"]);
});

test("ticks are round, within, and about as many as wanted", () => {
  assert.deepEqual(ticks(0, 1, 5), [0, 0.2, 0.4, 0.6, 0.8, 1]);
  assert.deepEqual(ticks(-0.13, 0.27, 4), [-0.1, 0, 0.1, 0.2]);
  for (const [lo, hi] of [[0, 0.7], [-3e-7, 8e-7], [1e6, 1.00001e6]]) {
    const list = ticks(lo, hi, 6);
    assert.ok(list.length >= 2 && list.length <= 8, String(list));
    assert.ok(list.every((v) => v >= lo - 1e-9 * Math.abs(lo) && v <= hi * (1 + 1e-9)));
  }
  assert.deepEqual(ticks(1, 1, 5), []);
  assert.deepEqual(ticks(NaN, 1, 5), []);
});

test("what is allowed is said in words, which tell a bound that is from one that is not", () => {
  const said = ["[0, 1]", "(0, 1]", "[0, 1)", "(0, 1)", "[2, inf)", "(0, inf)", "(-inf, 3]", "(-inf, 3)", ""].map(limits);
  assert.deepEqual(said, ["0 to 1", "above 0, up to 1", "0 to below 1", "above 0, below 1", "2 or more", "above 0", "up to 3", "below 3", ""]);
});

test("a slider stays within bounds that are open", () => {
  for (const [range, type, lo, hi] of /** @type {[string, string, number, number][]} */ ([
    ["(0, 1]", "number", 0.001, 1], ["[0, 1)", "number", 0, 0.999], ["(1, 2)", "number", 1.001, 1.999], ["(0, 8]", "whole number", 1, 8],
    ["[0, 8)", "whole number", 0, 7], ["(1e-6, 1)", "number", 1.01e-6, 0.986],
  ])) {
    const slider = slide({ name: "a", type, unit: "", range, value: "1", meaning: "", takes_effect: "" });
    assert.equal(slider?.from(0), lo, range);
    assert.equal(slider?.from(1000), hi, range);
  }
});

test("bounds are read as capabilities write them", () => {
  assert.deepEqual(bounds("[1e-3, 1]"), { lo: 0.001, hi: 1, openLo: false, openHi: false });
  assert.deepEqual(bounds("(0, inf)"), { lo: 0, hi: null, openLo: true, openHi: true });
  assert.deepEqual(bounds(""), { lo: null, hi: null, openLo: false, openHi: false });
  assert.deepEqual(vector("[0, -9.81, 1e-3]"), [0, -9.81, 0.001]);
  assert.deepEqual(vector("null"), []);
});

const parameter = { name: "scheme.cfl", type: "number", unit: "", range: "[1e-3, 1]", value: "0.25", meaning: "", takes_effect: "" };

test("a slider goes from bound to bound, by decades where there are many", () => {
  const wide = slide(parameter), narrow = slide({ ...parameter, range: "[0, 20]" }), whole = slide({ ...parameter, type: "whole number", range: "[0, 1024]" });
  assert.ok(wide && narrow && whole);
  assert.deepEqual([0, 333, 1000].map(wide.from), [0.001, 0.00998, 1]);
  assert.equal(narrow.from(500), 10);
  assert.equal(whole.from(500), 512);
  for (const place of [0, 250, 999, 1000]) assert.equal(wide.to(wide.from(place)), place);
  assert.equal(narrow.to(99), 1000);
  assert.equal(slide({ ...parameter, range: "[0, inf)" }), null);
  assert.equal(slide({ ...parameter, type: "list of formula", range: "" }), null);
});

test("words to choose from", () => {
  assert.deepEqual(choices({ ...parameter, type: "true or false" }), ["true", "false"]);
  assert.deepEqual(choices({ ...parameter, type: "by-size, cg, amg" }), ["by-size", "cg", "amg"]);
  assert.equal(choices(parameter), null);
});

test("a spray particle does not stretch the colour bar", () => {
  const values = Float32Array.from({ length: 1000 }, (_, k) => k);
  values[500] = 1e9;
  assert.deepEqual(spread(values), [10, 990]);
  assert.deepEqual(spread(values, (k) => k < 100), [1, 98]);
  assert.equal(spread(Float32Array.of(NaN)), null);
});

test("the colour bar is calm, holds when told, and never has no height", () => {
  const range = new Range();
  assert.deepEqual(range.follow([0, 10]), [0, 10]);
  const [, hi] = range.follow([0, 20]) ?? [];
  assert.ok(hi > 10 && hi < 20);
  range.held = true;
  assert.deepEqual(range.follow([0, 99]), [0, hi]);
  range.held = false;
  range.begin();
  const [a, b] = range.follow([5, 5]) ?? [];
  assert.ok(b > a);
  range.begin();
  assert.deepEqual(range.follow([-1, 3], true), [-3, 3]);
});

test("samples follow each other, and a new time line takes the place of the old", () => {
  const series = new Series();
  series.add(["a"], ["m"], [[0, 1], [1, 2], [2, null]]);
  assert.deepEqual(series.probes.get("a")?.v, [1, 2, null]);
  series.add(["a"], ["m"], [[1, 7]]);
  assert.deepEqual(series.probes.get("a")?.t, [0, 1]);
  assert.deepEqual(series.probes.get("a")?.v, [1, 7]);
  assert.equal(series.probes.get("a")?.unit, "m");
});

test("memory is bounded: when much has come, the thinned history is asked for", () => {
  const series = new Series();
  let asked = 0;
  for (let k = 0; k < 10 * MOST; k++)
    if (series.add(["a"], [""], [[k, k]])) {
      asked++;
      series.recall({ first: true, last: true, probes: [{ name: "a", unit: "", thinned: 1, t: [0, k], v: [0, k] }] });
    }
  assert.ok(asked >= 9);
  assert.ok((series.probes.get("a")?.t.length ?? 0) <= MOST + 1);
});

test("the history comes in pieces, and is not asked for again until it is whole", () => {
  const series = new Series(), past = (/** @type {string} */ name) => ({ name, unit: "", thinned: 0, t: [0], v: [7] });
  const rows = Array.from({ length: MOST + 2 }, (_, k) => [k, k]);
  series.add(["gone"], [""], [[0, 1]]);
  assert.equal(series.add(["a", "b"], ["", ""], rows.map(([t]) => [t, t, t])), true);
  series.recall({ first: true, last: false, probes: [past("a")] });
  assert.equal(series.add(["b"], [""], [[MOST + 2, 1]]), false);
  assert.deepEqual([...series.probes.keys()], ["gone", "a", "b"]); // nothing vanishes on the way
  series.recall({ first: false, last: true, probes: [past("b")] });
  assert.deepEqual([...series.probes.keys()], ["a", "b"]);
  assert.equal(series.add(["b"], [""], rows), true);
});

test("a lost connection is tried again, ever more patiently but never for long", () => {
  assert.deepEqual([0, 1, 2, 10].map(patience), [500, 1000, 2000, 8000]);
});

test("records of the journal in words", () => {
  assert.equal(deed({ changes: [{ path: "gravity", before: "[0, -1]", after: "[0, -5]" }], reply: { code: "OK" } }), "gravity: [0, -1] → [0, -5]");
  assert.equal(deed({ kind: "begun" }), "begun");
  assert.equal(deed({ kind: "scheduled", at_step: 30, at_time: null, reply: null }), "scheduled for step 30");
  assert.equal(deed({ kind: "scheduled", at_step: null, at_time: 6.5, reply: null }), "scheduled for t = 6.5 s");
  assert.equal(deed({ changes: [], reply: { code: "ABORTED", message: "ended" } }), "ended");
  assert.equal(deed({ changes: [], reply: { code: "ABORTED", message: null } }), "ABORTED");
  assert.equal(order({ command: "run_until", arguments: "0.17" }), "run until 0.17");
  assert.equal(order({ command: "pause", arguments: null }), "pause");
  assert.equal(deed({ reply: { code: "OK", state: "PAUSED" } }), "PAUSED");
});

test("what happened is told once, and without the directory of the run", () => {
  assert.equal(story({ topic: "event", what: "paused", text: "paused on request" }), "Paused on request");
  assert.equal(story({ topic: "event", what: "paused", text: "what was asked for is done" }, "/runs/a"), "Paused: what was asked for is done");
  assert.equal(story({ topic: "event", what: "ready", text: "restored from /runs/a/checkpoint-1.hdf" }, "/runs/a"), "Ready: restored from checkpoint-1.hdf");
  assert.equal(story({ topic: "event", what: "done", text: null }), "Done");
  assert.equal(story({ topic: "log", what: null, text: "fluids[1]: /runs/a/log is full" }, "/runs/a"), "fluids[1]: log is full");
});

test("what is to happen later is said as the gateway wants it", () => {
  const form = (/** @type {Record<string, string>} */ entries) => Object.entries(entries).reduce((f, [k, v]) => (f.set(k, v), f), new FormData());
  assert.deepEqual(appointment(form({ what: "pause", at: "120", unit: "step", settings: "" })), { do: "pause", at_step: 120 });
  assert.deepEqual(appointment(form({ what: "set", at: "0.5", unit: "time", settings: "gravity=[0, -2]\n\n end_time=3 " })),
    { do: "set", settings: ["gravity=[0, -2]", "end_time=3"], at_time: 0.5 });
  assert.equal(told({ id: "", at_step: 7, at_time: null, who: "local", what: "set" }), "set, at step 7");
  assert.equal(told({ id: "", at_step: null, at_time: 0.05, who: "local", what: "pause, at t = 0.05 s" }), "pause, at t = 0.05 s");
  assert.equal(told({ id: "", at_step: 7, at_time: null, who: "local", what: "set a = 1, at step 7" }), "set a = 1, at step 7");
});

test("an eye sees all corners of a box, and is no farther away than it must", () => {
  for (const [reach, up] of /** @type {[number[], number[]][]} */ ([[[2, 2, 2], [0, 0, 1]], [[5, 1, 2], [0, 1, 0]], [[1, 1, 9], [0, 0, 1]]]))
    for (const [wide, high] of [[0.364, 0.364], [0.1, 0.364], [0.8, 0.364]]) {
      const from = [0.41, up[1] ? 0.32 : -0.85, up[1] ? 0.85 : 0.32], far = Math.hypot(...from), unit = from.map((x) => x / far);
      const distance = distanceToFit(reach, from, up, wide, high), [a, b, c] = unit, [u, v, w] = up;
      const across = [v * c - w * b, w * a - u * c, u * b - v * a], right = across.map((x) => x / Math.hypot(...across));
      const top = [b * right[2] - c * right[1], c * right[0] - a * right[2], a * right[1] - b * right[0]];
      let most = 0;
      for (let k = 0; k < 8; k++) {
        const corner = reach.map((length, d) => (k & 1 << d ? length : -length) / 2), dot = (/** @type {number[]} */ axis) => axis[0] * corner[0] + axis[1] * corner[1] + axis[2] * corner[2];
        most = Math.max(most, Math.abs(dot(right)) / wide / (distance - dot(unit)), Math.abs(dot(top)) / high / (distance - dot(unit)));
      }
      assert.ok(Math.abs(most - 1) < 1e-9, `${reach} ${wide}: ${most}`);
    }
});

test("how fast a run comes back is known after a second, and anew after another crash", () => {
  const way = new Way();
  way.note(0, 100);
  way.note(0.5, 200);
  assert.deepEqual([way.rate(), way.left(1000)], [null, null]);
  way.note(2, 500);
  assert.deepEqual([way.rate(), way.left(900)], [200, 2]);
  for (let k = 3; k < 40; k++) way.note(k, 500 + 10 * k);
  assert.equal(way.rate(), 10);
  way.note(41, 3);
  assert.equal(way.rate(), null);
});

test("a lease that somebody has is told without words of a shell", () => {
  const held = plain({ status: "held", path: "lease_epoch", hint: "wait; `meniscus lease`",
    message: "anna holds the lease for another 28.2 s; nothing was done. Who holds it names it, by --lease or $MENISCUS_LEASE; others wait" });
  assert.deepEqual([held.message, held.path, held.lasting], ["anna holds the lease for another 28.2 s; nothing was done", "", false]);
  assert.match(held.hint, /Pause, Stop/);
  assert.doesNotMatch(held.hint, /meniscus|--/);
  assert.doesNotMatch(plain({ status: "wrong state", message: "cannot start while PAUSED", hint: "see `meniscus status`" }).hint, /meniscus/);
  const other = plain({ status: "invalid", message: "found never", path: "end_time", hint: "mend it" });
  assert.deepEqual([other.path, other.hint, other.lasting], ["end_time", "mend it", false]);
  const bare = plain({ status: "invalid", message: "found never", path: "at_time", hint: "mend what the message names and try again" });
  assert.deepEqual([bare.path, bare.hint], ["", ""]);
  assert.equal(plain({ status: "no space", message: "the disk is full" }).lasting, true);
});

test("what a run in FAULT can do is said with the names of the buttons, and nothing that is refused", () => {
  const diverged = { fault: "diverged in step 7", fault_reason: "diverged" };
  assert.equal(trouble(diverged).broken, true);
  assert.match(trouble({ ...diverged, can_restore: true }).hint, /press Go back, to the newest checkpoint/);
  assert.match(trouble({ ...diverged, can_restore: false }).hint, /press Go back, to the beginning, as there is no checkpoint/);
  const formula = trouble({ fault: 'gravity[0]: "sqrt(0.1-t)" is of no use', fault_reason: "invalid", can_restore: false });
  assert.deepEqual([formula.broken, formula.hint.endsWith("press Resume")], [false, true]);
  assert.match(trouble({ fault: "walls[0].surface_velocity[0]: no", fault_reason: "invalid" }).hint, /press Stop/);
  assert.equal(trouble({ fault: "the disk is full", fault_reason: "no space" }).broken, false);
  assert.deepEqual(["a", "a.", ""].map(sentence), ["a.", "a.", ""]);
});

test("what was ended on request says how far it came", () => {
  const error = { status: "interrupted", message: "paused on request" };
  assert.equal(brokenOff(error, { step: 1015, time: 0.5, state: "PAUSED" }, 1000), "Stopped after 15 steps: paused");
  assert.equal(brokenOff(error, { step: 1001, time: 0.5, state: "PAUSED" }, 1000), "Stopped after 1 step: paused");
  assert.equal(brokenOff(error, { step: 1001, time: 0.25, state: "PAUSED" }, 1000, 2), "Stopped at t = 0.25 s, before 2 s: paused");
  assert.equal(brokenOff({ ...error, message: "stopped on request" }, { step: 0, time: null, state: "EMPTY" }, 1000), "Ended: stopped");
  assert.equal(brokenOff(error, {}, 1000), "Ended: paused");
});

test("what cannot be seen in a title is shown as its escape", () => {
  assert.equal(shown("dam\nstate\t\u202egpj.exe\u200b\u0085\ufeff\u{e0001}"), "dam\\nstate\\t\\u202egpj.exe\\u200b\\u0085\\ufeff\\udb40\\udc01");
  assert.equal(shown("two\nlines \u202e", true), "two\nlines \\u202e");
  assert.equal(shown("Wasser, \u{1f600}, \u00b7 \u202f"), "Wasser, \u{1f600}, \u00b7 \u202f");
});
