// SPDX-License-Identifier: BSD-3-Clause
// The dashboard: takes what the gateway says to where it is shown, and what is clicked to the gateway.
import "uplot/dist/uPlot.min.css";
import "./app.css";
import { Charts } from "./charts.js";
import { count, duration, number, shown, ticks, vector } from "./format.js";
import { decode } from "./frame.js";
import { appointment, askLater, showLater, told } from "./later.js";
import { Link } from "./link.js";
import { Events, Journal } from "./logs.js";
import { Notes, confirmed } from "./notes.js";
import { Parameters, element } from "./parameters.js";
import { Range, spread } from "./range.js";
import { Series } from "./series.js";
import { View } from "./view.js";
import { Way } from "./way.js";
import { brokenOff, sentence, trouble } from "./words.js";

const $ = (/** @type {string} */ id) => /** @type {any} */ (document.getElementById(id));
const LIMITS = [20000, 100000, 300000, 1000000], USUAL_LIMIT = 100000, LEASE_S = 12, LOOKS = ["phase", "pressure", "velocity", "density"];
/** Fluids that hide the others in a space. */
const THIN = /(^|[^a-z])(air|gas|vapou?r|steam)([^a-z]|$)/i;

/** What is known. */
const known = {
  /** @type {any} */ about: null,
  /** @type {any} */ status: null,
  /** @type {any} */ progress: null,
  /** @type {any} */ daemon: null,
  linked: false, /** Closed for want of the token. */ locked: false, lost: 0, lease: 0, leaseSeen: false, renewed: -Infinity, drawn: 0,
  /** @type {import("./frame.js").Frame|null} */ frame: null,
  /** Which pictures are wanted. @type {any} */ wish: null,
  /** Why they cannot be had. @type {any} */ refused: null,
  /** @type {{colour: string, visible: boolean, name: string, wall: boolean}[]} */ phases: [],
  /** The run and its space, and that which is looked at. @type {string} */ space: "", seen: "",
  way: new Way(),
};

/** Something that is remembered in this browser. @param {string} key @param {string} [value] */
function kept(key, value) {
  try {
    if (value !== undefined) localStorage.setItem(`meniscus.${key}`, value);
    return localStorage.getItem(`meniscus.${key}`) ?? "";
  } catch {
    return ""; // a browser may forbid it
  }
}

/** Hold the lease of this epoch, 0: none. It outlives a page that is loaded again, not one that is opened beside. @param {number} epoch */
function hold(epoch) {
  known.lease = epoch;
  sessionStorage.setItem("meniscus.lease", String(epoch));
}
const arrival = /** @type {PerformanceNavigationTiming|undefined} */ (performance.getEntriesByType("navigation")[0]);
hold(arrival?.type === "reload" ? Number(sessionStorage.getItem("meniscus.lease")) : 0);

// --- connection ---------------------------------------------------------------------------------------------------------

/** The word that opens, from the address (…/#token=WORD), or as it was typed. */
let token = sessionStorage.getItem("meniscus.token") ?? "";
function takeToken() {
  if (!location.hash.startsWith("#token=")) return false;
  token = decodeURIComponent(location.hash.slice(7));
  sessionStorage.setItem("meniscus.token", token);
  history.replaceState(null, "", location.pathname);
  return true;
}
takeToken();
// The address of a gateway that was started anew, where the page of the one before is open.
addEventListener("hashchange", () => takeToken() && location.reload());

const link = new Link(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/`, {
  message: take, frame: takeFrame, token: () => token,
  change(open, reason) {
    known.linked = open;
    if (open) wish();
    known.locked = reason === "token";
    showState();
    if (known.locked) askToken();
  },
});

/** Who does not want to say it may look at the banner, which says where it is. */
async function askToken() {
  const input = element("input", { type: "password", name: "token", autocomplete: "off", required: true, ariaLabel: "Token" });
  const form = await confirmed($("ask"), token ? "That is not the token of this dashboard" : "This dashboard asks for a token", "It is in the address that meniscus-dashboard printed when it was started, or in the file that was given with --http-token.", "Open", input);
  if (!form) return;
  token = String(form.get("token"));
  sessionStorage.setItem("meniscus.token", token);
  link.open();
}

/** @param {import("./link.js").Message} message */
function take(message) {
  switch (message.topic) {
    case "hello":
      notes.settle("unsent");
      events.clear();
      series.coming = true; // without being asked for
      break;
    case "daemon": known.daemon = message; break;
    case "about": takeAbout(message); break;
    case "status":
      if (known.status && known.status.daemon_epoch !== message.daemon_epoch) notes.begin();
      known.status = message;
      known.progress = null;
      noteWay(message);
      renewLease();
      journal.follow(message.journal_bytes);
      break;
    case "progress":
      known.progress = message;
      noteWay(message);
      break;
    case "history": series.recall(/** @type {any} */ (message)); charts.stale = true; break;
    case "samples":
      if (series.add(message.names, message.units, message.rows)) link.send({ do: "history" });
      charts.stale = true;
      break;
    case "event": case "log":
      events.add(message);
      break;
    case "refused":
      if (["field", "limit", "walls"].every((key) => message[key] === known.wish?.[key])) known.refused = message.error;
      break;
    case "lost": known.lost += message.messages; break;
    default:
  }
  showState();
}

/** @param {any} now  status or progress */
function noteWay(now) {
  if (now.state === "RECOVERING") known.way.note(performance.now() / 1000, now.step);
  else known.way = new Way();
}

/** Say what is wanted in pictures. */
function wish() {
  known.wish = { field: $("field").value || "phase", limit: view ? Number($("limit").value) : 0, walls: $("walls").checked };
  known.refused = null;
  link.send({ do: "show", ...known.wish });
}

/**
 * Give a command and say what became of it.
 * @param {string} what  for people @param {{do: string, time?: number, [entry: string]: unknown}} message @param {(reply: any) => string} [done]  what to say; "" for nothing
 */
async function command(what, message, done = () => "") {
  const from = (known.progress ?? known.status)?.step ?? 0;
  notes.settle(message.do); // what became of the one before says nothing now
  const reply = await link.ask({ ...message, ...(known.lease ? { lease: known.lease } : {}) });
  if (reply.error?.status === "interrupted") notes.tell(brokenOff(reply.error, /** @type {any} */ (reply), from, message.time), message.do);
  else if (reply.error) notes.complain(what, reply.error, message.do);
  else notes.tell(done(reply), message.do);
  return reply;
}

// --- the case -----------------------------------------------------------------------------------------------------------

/** @param {any} about */
function takeAbout(about) {
  known.about = about;
  const { capabilities } = about, fields = capabilities.fields.map((/** @type {any} */ f) => f.name).filter((/** @type {string} */ n) => n !== "id");
  fill($("field"), [...LOOKS.filter((n) => fields.includes(n)), ...fields.filter((/** @type {string} */ n) => !LOOKS.includes(n))], kept("field") || "phase");
  fill($("map"), about.colour_maps.map((/** @type {any} */ m) => m.name), kept("map") || "viridis");
  parameters.show(about.case ? capabilities.parameters : []);
  if (!about.case) {
    known.space = "";
    known.frame = null;
    series.clear();
    charts.stale = true;
    return;
  }
  const min = vector(about.case["domain.min"].value), max = vector(about.case["domain.max"].value), dimensions = Number(about.case.dimensions.value);
  const gravity = vector(about.case.gravity?.value), strength = Math.hypot(...gravity);
  const up = dimensions === 3 && gravity.length === 3 && strength > 0 ? gravity.map((g) => -g / strength) : [0, 0, 1];
  const space = { dimensions, min, max, spacing: about.case.reference_length.value / about.case.resolution.value, up };
  const names = about.fluids.map((/** @type {any} */ f) => f.name), key = JSON.stringify([space.dimensions, min, max, space.spacing, names, known.status?.run_directory]);
  if (key === known.space) return;
  known.space = key;
  const several = about.fluids.length > 1;
  known.phases = [
    ...about.fluids.map((/** @type {any} */ f) => ({ ...f, visible: !(dimensions === 3 && several && THIN.test(f.name)), wall: false })),
    ...about.walls.map((/** @type {string} */ name) => ({ name, colour: "#8a8f98", visible: true, wall: true })),
  ];
  if (JSON.stringify(space) !== known.seen) view?.setSpace(/** @type {any} */ (space)); // else whoever looks from somewhere stays there
  known.seen = JSON.stringify(space);
  view?.setPhases(known.phases);
  showMap();
  range.begin();
  legend();
}

/** @param {HTMLSelectElement} select @param {string[]} names @param {string} wanted */
function fill(select, names, wanted) {
  const chosen = select.value || wanted;
  select.replaceChildren(...names.map((name) => element("option", { value: name }, name.replaceAll("_", " "))));
  select.value = names.includes(chosen) ? chosen : names[0];
}

// --- pictures -----------------------------------------------------------------------------------------------------------

const view = begin(), range = new Range(), notes = new Notes($("notes"));

/** Without WebGL there are no pictures, and all else goes on. */
function begin() {
  try {
    return new View($("canvas"));
  } catch {
    for (const control of document.querySelectorAll(".toolbar select, .toolbar input, .toolbar button")) /** @type {any} */ (control).disabled = true;
    return null;
  }
}

/** Times at which pictures came, of the last seconds. @type {number[]} */
let pace = [];

/** @param {ArrayBuffer} buffer */
function takeFrame(buffer) {
  known.drawn++;
  const frame = decode(buffer);
  if (frame.field !== $("field").value || frame.walls !== $("walls").checked) return;
  if (frame.step !== known.frame?.step) pace.push(performance.now());
  known.frame = frame;
  known.refused = null;
  view?.setFrame(frame);
  if (frame.value) view?.setRange(range.follow(spread(frame.value, (k) => !known.phases[frame.phase[k]]?.wall && known.phases[frame.phase[k]]?.visible !== false), isDiverging()));
  showBar();
}

function isDiverging() {
  return Boolean(known.about?.colour_maps.find((/** @type {any} */ m) => m.name === $("map").value)?.diverges);
}

function showMap() {
  const map = known.about?.colour_maps.find((/** @type {any} */ m) => m.name === $("map").value);
  if (!map) return;
  view?.setMap(map.stops);
  const canvas = $("bar-canvas"), pen = canvas.getContext("2d"), shade = pen.createLinearGradient(0, canvas.height, 0, 0);
  map.stops.forEach((/** @type {string} */ colour, /** @type {number} */ k) => shade.addColorStop(k / (map.stops.length - 1), colour));
  pen.fillStyle = shade;
  pen.fillRect(0, 0, canvas.width, canvas.height);
}

/** Which fluids there are, with a switch for each. */
function legend() {
  $("bar").querySelector(".legend")?.remove();
  const list = element("div", { className: "legend" });
  for (const phase of known.phases) {
    if (phase.wall && !$("walls").checked) continue;
    const input = element("input", { type: "checkbox", checked: phase.visible });
    input.onchange = () => {
      phase.visible = input.checked;
      view?.setPhases(known.phases);
    };
    const dot = element("i");
    dot.style.background = phase.colour;
    list.append(element("label", {}, input, dot, phase.name));
  }
  list.classList.toggle("below", $("field").value !== "phase");
  $("bar").append(list);
}

function showBar() {
  const frame = known.frame, ends = range.ends;
  $("bar").hidden = !frame;
  if (!frame) return;
  const unit = frame.unit === "1" || !frame.unit ? "" : ` (${frame.unit})`, name = frame.field.replaceAll("_", " ");
  $("bar-title").textContent = frame.value ? `${frame.magnitude ? `|${name}|` : name}${unit}` : "fluid";
  $("bar-body").hidden = !frame.value;
  if (!frame.value || !ends) return;
  const [lo, hi] = ends;
  $("bar-title").title = "98 % of the values lie within; those beyond have the colour of that end";
  $("bar-ticks").replaceChildren(...ticks(lo, hi, 6).map((value) => {
    const tick = element("span", {}, number(value, 4));
    tick.style.bottom = `${100 * (value - lo) / (hi - lo)}%`;
    return tick;
  }));
}

function showShown() {
  const frame = known.frame, now = performance.now();
  pace = pace.filter((t) => now - t < 2000);
  if (known.refused && stateNow() !== "EMPTY") { // that no case is loaded is said in the middle
    $("shown").replaceChildren(element("b", {}, `No picture: ${known.refused.message}`));
    $("pace").textContent = "";
    return;
  }
  if (!frame || ["EMPTY", "RECOVERING"].includes(stateNow())) { // what was drawn before the crash is not shown
    $("shown").textContent = $("pace").textContent = "";
    return;
  }
  const whole = frame.every === 1, hidden = known.phases.filter((phase) => !phase.visible && !phase.wall).map((phase) => phase.name);
  const without = hidden.length ? ` · ${hidden.join(", ")} hidden` : "";
  $("shown").replaceChildren(...(whole ? [`All ${count(frame.all)} particles${without}`]
    : [element("b", {}, `Thinned: ${count(frame.particles)} of ${count(frame.all)} particles, about one in ${frame.every}, drawn larger${without}`)]));
  const parts = [];
  if (known.status?.state === "RUNNING") parts.push(`${number(pace.length / 2, 2)} pictures/s`);
  if (frame.skipped) parts.push(`dropped pictures: ${count(frame.skipped)}`);
  if (known.lost) parts.push(`dropped samples: ${count(known.lost)}`);
  parts.push(`step ${count(frame.step)}`);
  $("pace").textContent = parts.join(" · ");
}

// --- state --------------------------------------------------------------------------------------------------------------

/** The state of the run, AWAY if nobody knows. */
function stateNow() {
  return known.linked && known.daemon?.alive ? known.progress?.state ?? known.status?.state ?? "EMPTY" : "AWAY";
}

/** What the one large button does in each state. */
const GO = { READY: ["Start", "start"], RUNNING: ["Pause", "pause"], PAUSED: ["Resume", "resume"], FAULT: ["Resume", "resume"] };
const MOVES = ["READY", "PAUSED"], LOADED = ["READY", "RUNNING", "PAUSED", "DONE", "FAULT"];

function showState() {
  const state = stateNow(), status = known.status ?? {}, progress = known.progress ?? status, has = LOADED.includes(state);
  $("state").textContent = state === "AWAY" ? "NOT CONNECTED" : state;
  $("state").dataset.state = state;
  $("title").textContent = $("title").title = shown(status.title || status.case || "Meniscus"); // where it is cut, the tooltip has all of it
  $("subtitle").textContent = [known.daemon?.name && `daemon ${known.daemon.name}`, status.case].filter(Boolean).join(" · ");
  document.title = `${state === "AWAY" ? "?" : state} ${status.case || "Meniscus"}`;
  const go = GO[/** @type {keyof typeof GO} */ (state)] ?? ["Start", ""];
  $("go").textContent = go[0];
  $("go").dataset.do = go[1];
  const lockedBy = status.lease_holder && !known.lease ? status.lease_holder : "";
  const why = lockedBy ? `${lockedBy} holds the lease` : state === "AWAY" ? "not connected" : `not possible while ${state}`;
  const broken = state === "FAULT" && trouble(status).broken; // Go back is the way on
  /** @type {[string, boolean, boolean][]} button, possible in this state, needs the lease */
  const buttons = [["go", Boolean(go[1]) && !broken, go[1] !== "pause"], ["step", MOVES.includes(state), true], ["until", MOVES.includes(state), true],
    ["snapshot", has, false], ["checkpoint", has && !broken, false], ["later", has && state !== "FAULT", false], ["back", has && state !== "RUNNING", true], ["stop", has || state === "RECOVERING", false]];
  for (const [id, possible, leased] of buttons) {
    const may = possible && !(leased && lockedBy);
    $(id).disabled = !may;
    $(id).dataset.title ??= $(id).title;
    $(id).title = may ? $(id).dataset.title : why;
  }
  const time = progress.time ?? null, end = progress.end_time ?? null, back = state === "RECOVERING" && status.recovery_step;
  if (back) showWay(progress, back);
  else {
    $("progress").value = has && end > 0 ? Math.min(1, time / end) : 0;
    $("clock").textContent = has ? `t = ${number(time, 6)} s of ${number(end, 6)} s · step ${count(progress.step ?? 0)} · Δt ${number(progress.time_step, 3)} s` : "";
    $("eta").textContent = state === "RUNNING"
      ? `${number(progress.steps_per_second, 3)} steps/s · ${duration(progress.eta_s)} to go` : state === "DONE" ? "end time reached" : "";
  }
  if (!$("until-time").value && end) $("until-time").placeholder = number(end, 4);
  showLater($("scheduled"), has ? status.scheduled ?? [] : [], (one) => command("Not called off", { do: "cancel", request: one.id }, () => `Called off: ${told(one)}`));
  showLease(status);
  showBanner(state, status);
  showEmpty(state);
  showShown();
}

/** On the way back after a crash. @param {any} progress @param {number} goal  step */
function showWay(progress, goal) {
  const rate = known.way.rate(), step = progress.step ?? 0;
  $("progress").value = Math.min(1, step / goal);
  $("clock").textContent = `coming back: step ${count(step)} of ${count(goal)} · t = ${number(progress.time, 6)} s`;
  $("eta").textContent = rate === null ? "" : `${number(rate, 3)} steps/s · back in ${duration(known.way.left(goal))}`;
}

/** @param {any} status */
function showLease(status) {
  if (!status.lease_holder || known.lease) notes.settle("held");
  if (known.lease && !status.lease_holder && known.leaseSeen) hold(0);
  known.leaseSeen = Boolean(known.lease && status.lease_holder);
  const holder = status.lease_holder;
  $("lease").textContent = known.lease ? "You hold the lease" : holder ? `${holder} holds the lease, ${number(status.lease_s, 2)} s` : "";
  $("lease-button").hidden = stateNow() === "AWAY" || Boolean(holder && !known.lease);
  $("lease-button").textContent = known.lease ? "Give the lease back" : "Take the lease";
  $("lease-button").title = "Who holds the lease is the only one to change the run";
}

/** @param {string} state @param {any} status */
function showBanner(state, status) {
  let words = ["", "", ""];
  if (known.locked) words = ["This dashboard is closed to who has not its token.", "", "open the address that meniscus-dashboard printed, or reload this page and enter it"];
  else if (!known.linked) words = ["The dashboard's server does not answer.", "It is tried again by itself.", ""];
  else if (known.daemon && !known.daemon.alive && known.daemon.error?.status === "unavailable")
    words = ["The daemon does not answer.", "It is asked again by itself.", "if it has ended, start it with the same --name and --state-dir: it comes back to its run"];
  else if (known.daemon && !known.daemon.alive) words = ["The daemon does not answer.", known.daemon.error?.message ?? "", known.daemon.error?.hint ?? ""];
  else if (state === "FAULT") words = ["The run has stopped.", status.fault ?? "", trouble(status).hint];
  const text = words.join("|");
  if ($("banner").dataset.text === text) return;
  $("banner").dataset.text = text;
  $("banner").hidden = !words[0];
  $("banner").replaceChildren(element("b", {}, words[0]), ` ${sentence(words[1])}`, words[2] ? element("span", { className: "muted" }, ` What to do: ${words[2]}.`) : "");
}

/** @param {string} state */
function showEmpty(state) {
  const kind = state === "EMPTY" ? "load" : ["LOADING", "RECOVERING", "STOPPING"].includes(state) ? state : !view && LOADED.includes(state) ? "BLIND" : known.frame ? "" : known.locked ? "CLOSED" : state;
  const empty = $("empty");
  if (empty.dataset.kind === kind) return;
  empty.dataset.kind = kind;
  empty.hidden = !kind;
  const says = { LOADING: ["The case is being loaded", "Particles are placed; large cases take a while."], RECOVERING: ["The run is coming back", "After a crash, what came after the newest checkpoint is done again; how far it is stands below. Its particles are here when it is back."],
    STOPPING: ["The daemon is leaving", ""], BLIND: ["This browser cannot draw the particles", "It has no WebGL, or was told to do without. Probes, parameters and all commands work as ever."],
    CLOSED: ["Not connected", ""], AWAY: ["Not connected", "As soon as the daemon answers, its particles are here."] };
  const [title, text] = says[/** @type {keyof typeof says} */ (kind)] ?? ["Waiting for the first picture", ""];
  if (kind !== "load") {
    empty.replaceChildren(element("h2", {}, title), element("p", {}, text));
    return;
  }
  const name = element("input", { placeholder: "dambreak2d", ariaLabel: "Name of the case", id: "load-name", required: true });
  const names = element("datalist", { id: "load-names" });
  name.setAttribute("list", names.id);
  name.onfocus = () => names.replaceChildren(...(known.about?.cases ?? []).map((/** @type {string} */ value) => element("option", { value })));
  const resolution = element("input", { type: "number", min: "1", step: "any", placeholder: "as in the case", ariaLabel: "Resolution" });
  resolution.style.width = "130px";
  const form = element("form", {}, name, names, element("label", { className: "muted" }, "resolution ", resolution), element("button", { className: "primary", id: "load" }, "Load"));
  form.onsubmit = (event) => {
    event.preventDefault();
    const settings = resolution.value ? { settings: [`resolution=${resolution.value}`] } : {};
    command("Cannot load", { do: "load", name: name.value.trim(), ...settings });
  };
  empty.replaceChildren(element("h2", {}, "No case is loaded"), element("p", {}, "Give the name of a case that comes with Meniscus, as dambreak2d or dambreak3d."), form,
    element("p", {}, "A file of your own: ", element("code", {}, `meniscus -d ${known.daemon?.name ?? "NAME"} load FILE.yaml`)));
}

// --- panels -------------------------------------------------------------------------------------------------------------

const series = new Series(), charts = new Charts($("probes"), series);
const events = new Events($("events"), () => known.status?.run_directory);
const journal = new Journal($("journal"), () => link.ask({ do: "journal" }));
const parameters = new Parameters($("parameters"), async (settings) => {
  const reply = await command("Not set", { do: "set", settings }, (r) => `In effect from step ${count(r.effect_step)}: ${settings.join(", ")}`);
  return !reply.error;
});

const tabs = [...document.querySelectorAll("[role=tab]")];
/** @param {any} chosen */
function openTab(chosen) {
  for (const tab of /** @type {any[]} */ (tabs)) {
    tab.setAttribute("aria-selected", String(tab === chosen));
    tab.tabIndex = tab === chosen ? 0 : -1;
    $(tab.getAttribute("aria-controls")).hidden = tab !== chosen;
  }
  kept("tab", chosen.id);
  if (chosen.id === "tab-journal") journal.open(known.status?.journal_bytes);
  charts.fit();
  charts.stale = true;
}
for (const tab of /** @type {any[]} */ (tabs)) {
  tab.onclick = () => openTab(tab);
  tab.onkeydown = (/** @type {KeyboardEvent} */ event) => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!by) return;
    const next = /** @type {HTMLElement} */ (tabs[(tabs.indexOf(tab) + by + tabs.length) % tabs.length]);
    next.focus();
    openTab(next);
  };
}
openTab($(kept("tab")) ?? tabs[0]);

// --- what is clicked ----------------------------------------------------------------------------------------------------

$("go").onclick = () => $("go").dataset.do && command(`Cannot ${$("go").dataset.do}`, { do: $("go").dataset.do });
$("step-form").onsubmit = (/** @type {Event} */ event) => {
  event.preventDefault();
  command("Not stepped", { do: "step", count: Number($("step-count").value) || 1 });
};
$("until-form").onsubmit = (/** @type {Event} */ event) => {
  event.preventDefault();
  const time = Number($("until-time").value || known.status?.end_time);
  command("Not run", { do: "run_until", time }, (r) => `Reached t = ${number(r.time, 6)} s, step ${count(r.step)}`);
};
for (const id of ["snapshot", "checkpoint"])
  $(id).onclick = () => command(`No ${id}`, { do: id }, (r) => `Written: ${r.path}`);
$("later").onclick = async () => {
  const form = await askLater($("ask"), (known.progress ?? known.status)?.time ?? 0);
  if (form) command("Not scheduled", appointment(form), (r) => r.message);
};
$("back").onclick = async () => {
  const ways = [["restore", "the newest checkpoint", "With the case as it was then."], ["reset", "the beginning", "What was set since the case was loaded is undone."]].filter(([value]) => value !== "restore" || known.status?.can_restore !== false).map(([value, name, text], k) =>
    element("p", {}, element("label", {}, element("input", { type: "radio", name: "way", value, checked: k === 0 }), ` To ${name}. `, element("span", { className: "muted" }, text))));
  const form = await confirmed($("ask"), "Go back?", "Files of this time line, from there on, move to the folder abandoned.", "Go back", ...ways);
  if (form) command("Not gone back", { do: String(form.get("way")) }, (r) => `Back at t = ${number(r.time, 6)} s, step ${count(r.step)}`);
};
$("stop").onclick = async () => {
  if (stateNow() === "RECOVERING") {
    const sure = await confirmed($("ask"), "End the run on its way back?", "Its files stay as they are, and none is written of this moment: what came after the newest checkpoint is given up.", "Stop the run");
    if (sure) command("Not stopped", { do: "stop", checkpoint: false }, (r) => `Ended; the files are in ${r.path}`);
    return;
  }
  const keep = element("input", { type: "checkbox", name: "checkpoint", checked: true });
  const form = await confirmed($("ask"), "End the run?", "Its files stay; the daemon can then load another case.", "Stop the run", element("label", {}, keep, " write a checkpoint first"));
  if (form) command("Not stopped", { do: "stop", checkpoint: form.has("checkpoint") }, (r) => `Ended; the files are in ${r.path}`);
};
$("parameters").addEventListener("input", () => notes.settle("set")); // what was refused is being mended
$("lease-button").onclick = async () => {
  if (known.lease) {
    await command("Not given back", { do: "release", lease: known.lease });
    hold(0);
    return showState();
  }
  const name = element("input", { name: "holder", value: kept("holder") || "dashboard", maxLength: 60, required: true, ariaLabel: "Your name" });
  const form = await confirmed($("ask"), "Take the lease", `While this page is open, and ${LEASE_S} s longer, nobody else can change the run; pausing and stopping stay possible. What shall others read?`, "Take it", name);
  if (form) holdLease(kept("holder", String(form.get("holder"))) || String(form.get("holder")));
};

/** @param {string} holder */
async function holdLease(holder) {
  const reply = await command("No lease", { do: "lease", seconds: LEASE_S, holder });
  hold(reply.lease_epoch ?? 0);
  if (known.lease) notes.settle("expired");
  known.renewed = performance.now();
  showState();
}

/** With each status that comes, as browsers let the timers of a page in the background sleep for longer than a lease lasts. */
async function renewLease() {
  const now = performance.now();
  if (!known.lease || now - known.renewed < LEASE_S * 1000 / 3) return;
  known.renewed = now;
  const reply = await link.ask({ do: "lease", seconds: LEASE_S, holder: kept("holder") || "dashboard", lease: known.lease });
  if (!reply.error || !known.lease) return;
  hold(0);
  notes.complain("The lease is lost", reply.error, "lease");
}

for (const limit of LIMITS) $("limit").append(element("option", { value: String(limit), selected: limit === USUAL_LIMIT }, `≈ ${count(limit)}`));
for (const id of ["field", "walls", "limit"])
  $(id).onchange = () => {
    if (id === "field") kept("field", $("field").value);
    range.begin();
    legend();
    wish();
  };
$("map").onchange = () => {
  kept("map", $("map").value);
  range.begin();
  showMap();
};
$("hold").onchange = () => { range.held = $("hold").checked; };
$("home").onclick = () => view?.home();
$("canvas").onkeydown = (/** @type {KeyboardEvent} */ event) => {
  if (!event.ctrlKey && !event.metaKey && !event.altKey && view?.key(event)) event.preventDefault();
};

/** @param {string} theme */
function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  if (view) view.stale = true;
  charts.rebuild();
}
const dark = matchMedia("(prefers-color-scheme: dark)");
setTheme(kept("theme") || (dark.matches ? "dark" : "light"));
dark.onchange = () => kept("theme") || setTheme(dark.matches ? "dark" : "light");
$("theme").onclick = () => setTheme(kept("theme", document.documentElement.dataset.theme === "dark" ? "light" : "dark"));

/** @param {number} now */
function draw(now) {
  const style = getComputedStyle(document.documentElement);
  view?.draw({ ink: style.getPropertyValue("--muted").trim(), paper: style.getPropertyValue("--stage").trim() });
  charts.draw(now);
  if (known.drawn) {
    link.send({ do: "drawn", count: known.drawn });
    known.drawn = 0;
  }
  requestAnimationFrame(draw);
}
requestAnimationFrame(draw);
setInterval(showShown, 500);
showState();
