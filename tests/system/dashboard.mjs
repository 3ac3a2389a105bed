// SPDX-License-Identifier: BSD-3-Clause
// A person at the dashboard, for test_dashboard.py: clicks and keys against a real daemon, in two browsers at once.
import { PATIENCE_MS, complaints, dropGateway, elsewhere, endGateway, hold, holdSoon, launch, open, picture, pixels, see, startGateway, state, step, text, token } from "./page.mjs";

await startGateway();
const chromium = await launch();

const count = (n) => String(n).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
const WATER = [0x1f, 0x78, 0xb4];

try {
  const page = await open(chromium, "light"), other = await open(chromium, "dark");
  await see(page, "No case is loaded", "an empty daemon is explained");
  hold(await other.$eval(":root", (root) => root.dataset.theme === "dark"), "who likes it dark gets it dark");
  await picture(page, "empty");

  const stranger = await open(chromium, "light", undefined, false);
  await see(stranger, "This dashboard asks for a token", "who has no token is asked for it", "#ask");
  await see(stranger, "closed to who has not its token", "and is not told of a server that is away", "#banner");
  await stranger.type("#ask input", "wrong");
  await stranger.keyboard.press("Enter");
  await see(stranger, "That is not the token", "a wrong one is called wrong", "#ask");
  await stranger.keyboard.press("Escape");
  await stranger.waitForSelector("#ask:not([open])");
  await picture(stranger, "closed");
  await stranger.reload();
  await see(stranger, "That is not the token", "it is asked for again", "#ask");
  await stranger.type("#ask input", token());
  await stranger.keyboard.press("Enter");
  await see(stranger, "No case is loaded", "the right one opens");
  await stranger.close();

  await page.focus("#load-name");
  hold(await page.$$eval("#load-names option", (options) => options.some((option) => option.value === "dambreak2d")), "names of cases are offered");
  await page.type("#load-name", "no-such-case");
  await page.keyboard.press("Enter");
  await see(page, "there is no case \"no-such-case\"", "a case that is not there is refused in the daemon's words", "#notes");
  await see(page, "What to do:", "with what to do", "#notes");
  await page.$eval("#load-name", (input) => { input.value = ""; });
  await page.type("#load-name", "dambreak2d");
  await page.click("#empty input[type=number]");
  await page.keyboard.type("20");
  await page.click("#load");
  await state(page, "READY");
  await state(other, "READY");
  await see(page, "All 4\u202f280 particles", "all particles are there, and the page says so", "#shown");
  await page.waitForFunction(() => !document.querySelector("#bar").hidden);
  await holdSoon(async () => await pixels(page, WATER) > 5000, "the water is blue");

  await page.click("#go");
  await state(page, "RUNNING");
  await state(other, "RUNNING");
  await other.waitForFunction(() => document.querySelector("#progress").value > 0.001, { timeout: PATIENCE_MS });
  await see(page, "to go", "it says how long yet", "#eta");
  await other.waitForFunction(() => document.querySelectorAll("figure .uplot").length >= 10, { timeout: PATIENCE_MS });
  hold(/ Pa$/.test(await text(other, "figure[data-probe=P05] .value")), "probes are drawn, with their unit");
  await page.select("#field", "pressure");
  await see(page, "pressure (Pa)", "the colour bar names its unit", "#bar-title");
  await picture(page, "running");
  await other.click("#go");
  await state(page, "PAUSED");

  const before = await step(page);
  await page.$eval("#step-count", (input) => { input.value = "5"; });
  await page.click("#step");
  await page.waitForFunction((wanted) => document.querySelector("#clock").textContent.replaceAll("\u202f", "").includes(`step ${wanted} `), { timeout: PATIENCE_MS }, before + 5);
  hold(await step(page) === before + 5, "five steps are five steps");
  const goal = (Number(/t = ([\d.e-]+)/.exec(await text(page, "#clock"))[1]) + 0.05).toFixed(3);
  await page.type("#until-time", goal);
  await page.keyboard.press("Enter");
  await see(page, `Reached t = ${Number(goal)} s`, "it runs to a time, exactly", "#notes");

  await page.$eval("#step-count", (input) => { input.value = "99999999999"; });
  const begun = await step(page);
  await page.click("#step");
  await state(page, "RUNNING");
  await page.click("#go");
  await see(page, "Stopped after", "what was ended on request is told as such", "#notes");
  await state(page, "PAUSED");
  const note = await text(page, "#notes");
  hold(note.startsWith(`Stopped after ${count(await step(page) - begun)} steps: paused`) && !note.includes("meniscus"), `with how far it came, and as no failure: ${note}`);
  hold(await page.$("#notes .bad") === null, "in no red box");
  await page.$eval("#step-count", (input) => { input.value = "5"; });

  await page.click("#later");
  await page.waitForSelector("#ask[open]");
  await page.select("#ask [name=what]", "set");
  await page.type("#ask [name=settings]", "output.snapshot_interval=0.7");
  await page.type("#ask [name=at]", "6.5");
  await picture(page, "later");
  await page.click("#ask .primary");
  await see(other, "at t = 6.5 s", "what is to happen later is listed, for others too", "#scheduled");
  const asked = "set output.snapshot_interval = 0.7, at t = 6.5 s";
  hold((await text(other, "#scheduled span")).startsWith(asked) && (await text(other, "#scheduled")).split("6.5").length === 2, "its time once");
  hold(await other.$eval("#scheduled button", (button) => button.ariaLabel) === `Call off: ${asked}`, "also for who hears it");
  await other.click("#scheduled button");
  await page.waitForFunction(() => document.querySelector("#scheduled").hidden, { timeout: PATIENCE_MS });
  console.log("so: and can be called off");

  await page.click("#tab-parameters");
  await page.focus("[id='set-scheme.cfl']");
  await page.keyboard.down("Control");
  await page.keyboard.press("a");
  await page.keyboard.up("Control");
  await page.keyboard.type("0.2");
  await see(page, "Apply 1 change", "changes are collected");
  const heard = await page.$eval("[aria-label='scheme: cfl, slider']", (slider) => slider.ariaValueText);
  if (heard !== "0.2") throw new Error(`a slider is heard as ${heard}`);
  await page.keyboard.press("Enter");
  await see(page, "scheme.cfl=0.2", "and set together", "#notes");
  await picture(page, "parameters");
  await other.waitForFunction(() => document.querySelector("[id='set-scheme.cfl']")?.value === "0.2", { timeout: PATIENCE_MS });
  await page.$eval("#set-gravity", (input) => { input.value = "nonsense"; input.dispatchEvent(new Event("input")); });
  await page.click("#parameters .primary");
  await see(page, "Not set:", "what is wrong is refused", "#notes");
  await page.click("#parameters .foot button:last-child");
  await page.click("#snapshot");
  await see(page, "snapshot-", "a snapshot is written", "#notes");
  await page.click("#checkpoint");
  await see(page, "checkpoint-", "and a checkpoint", "#notes");
  const kept = await step(page);

  await page.click("#step");
  await page.waitForFunction((wanted) => document.querySelector("#clock").textContent.replaceAll("\u202f", "").includes(`step ${wanted} `), { timeout: PATIENCE_MS }, kept + 5);
  await page.click("#back");
  await page.waitForSelector("#ask[open]");
  await picture(page, "back");
  await page.click("#ask .primary");
  await see(page, "Back at t =", "it goes back to the checkpoint", "#notes");
  await page.waitForFunction((wanted) => document.querySelector("#clock").textContent.replaceAll("\u202f", "").includes(`step ${wanted} `), { timeout: PATIENCE_MS }, kept);
  await state(page, "READY");

  await page.click("#tab-events");
  await see(page, "Paused", "events are listed", "#events");
  await see(page, "Ready: restored from checkpoint-", "with the names of files", "#events");
  hold(!/Paused: paused|\/checkpoint-/.test(await page.$eval("#events", (panel) => panel.innerText)), "and nothing twice");
  await picture(page, "events");
  await page.click("#tab-journal");
  await see(page, "scheme.cfl: 0.25 → 0.2", "the journal has what was set, from what to what", "#journal");
  await see(page, "set output.snapshot_interval = 0.7", "what was scheduled is told", "#journal");
  await see(page, "scheduled for t = 6.5 s", "with its time", "#journal");
  await picture(page, "journal");
  const rows = (wanted) => page.$$eval("#journal tbody tr", (all, word) => all.filter((row) => row.cells[2].innerText === word).length, wanted);
  const snapshots = await rows("snapshot"), checkpoints = await rows("checkpoint");
  await page.click("#snapshot"); // of which there is no event
  await holdSoon(async () => await rows("snapshot") === snapshots + 1, "it is read again when there is more in it");
  hold(await page.$eval("#journal", (panel) => panel.scrollTop === 0 && panel.querySelector("tbody tr").innerText.includes("snapshot")), "the newest is seen by who looks at the newest");
  await page.setViewport({ width: 1280, height: 500 });
  await page.$eval("#journal", (panel) => { panel.scrollTop = 90; });
  const seen = () => page.$eval("#journal", (panel) => {
    const row = [...panel.querySelectorAll("tbody tr")].find((each) => each.innerText.includes("scheme.cfl"));
    return Math.round(row.getBoundingClientRect().top);
  });
  const lay = await seen();
  await page.click("#checkpoint");
  await holdSoon(async () => await rows("checkpoint") === checkpoints + 1, "and by who reads farther down");
  hold(Math.abs(await seen() - lay) <= 1, "whose lines stay where they are");
  await page.setViewport({ width: 1280, height: 800 });

  await page.click("#lease-button");
  await page.waitForSelector("#ask[open]");
  await page.keyboard.press("Enter");
  await see(page, "You hold the lease", "the lease can be had", "#lease");
  await see(other, "dashboard holds the lease", "others see who has it", "#lease");
  hold(await other.$eval("#go", (button) => button.disabled && button.title.includes("holds the lease")), "and why they cannot go on");
  await page.reload();
  await see(page, "You hold the lease", "a page that is loaded again keeps it", "#lease");
  hold(await page.$eval("#go", (button) => !button.disabled), "and may go on");
  await other.click("#tab-parameters");
  await other.$eval("[id='set-scheme.cfl']", (input) => { input.value = "0.21"; input.dispatchEvent(new Event("input")); });
  await other.click("#parameters .primary");
  await see(other, "dashboard holds the lease for another", "who is refused for it learns who has it, and for how long", "#notes");
  const refusal = await text(other, "#notes");
  hold(!/--lease|MENISCUS_LEASE|lease_epoch/.test(refusal), `in words of the page: ${refusal}`);
  await page.focus("#go");
  await page.keyboard.press("Enter");
  await state(other, "RUNNING");
  await other.click("#go");
  await state(page, "PAUSED");
  await page.click("#lease-button");
  await other.waitForFunction(() => !document.querySelector("#go").disabled, { timeout: PATIENCE_MS });
  hold(!(await text(other, "#notes")).includes("holds the lease"), "when it is given back, nothing says that it is held");

  await other.$eval("#limit", (select) => { select.options[0].value = "1000"; select.selectedIndex = 0; select.dispatchEvent(new Event("change")); });
  await see(other, "Thinned:", "a picture of fewer particles than there are says so", "#shown");
  await see(other, "of 4\u202f280 particles", "and of how many", "#shown");
  await other.focus("#canvas");
  const still = await other.$eval("#canvas canvas", (c) => c.toDataURL());
  await other.keyboard.press("ArrowLeft");
  await other.keyboard.press("+");
  await other.waitForFunction((was) => document.querySelector("#canvas canvas").toDataURL() !== was, { timeout: PATIENCE_MS, polling: 100 }, still);
  console.log("so: the picture can be moved without a mouse");
  await other.setViewport({ width: 320, height: 568 });
  hold(await other.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "a narrow window has all of it");
  await picture(other, "narrow");
  await other.click("#theme");
  hold(await other.$eval(":root", (root) => root.dataset.theme === "light"), "dark and light can be chosen");

  hold(complaints.length === 0, `nothing goes wrong in the pages: ${complaints}`);
  await endGateway();
  await see(page, "The dashboard's server does not answer.", "a gateway that is gone is told");
  await picture(page, "away");
  await startGateway();
  await page.waitForFunction(() => document.querySelector("#banner").hidden, { timeout: PATIENCE_MS });
  await state(page, "PAUSED");
  hold(elsewhere.length === 0, `nothing is fetched from elsewhere: ${elsewhere}`);

  await page.click("#stop");
  await page.waitForSelector("#ask[open]");
  await page.keyboard.press("Escape");
  hold(/PAUSED/.test(await text(page, "#state")), "who does not confirm has not stopped the run");
  await page.click("#stop");
  await page.waitForSelector("#ask[open]");
  await page.click("#ask .primary");
  await state(page, "EMPTY");
  await see(page, "No case is loaded", "then another case can be loaded");
  await endGateway();
} finally {
  await chromium.close();
  dropGateway();
}
