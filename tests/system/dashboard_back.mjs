// SPDX-License-Identifier: BSD-3-Clause
// A crash and the way back, for test_dashboard.py, which has a paused run that went far and does to the daemon what is printed here.
import { PATIENCE_MS, complaints, dropGateway, endGateway, hold, launch, open, picture, see, startGateway, state, step, text } from "./page.mjs";

const NOTICED_MS = 2000; // half a second where processors are free
const FOUND_MS = 4000; // the daemon's start, and the same

await startGateway();
const chromium = await launch();

try {
  const page = await open(chromium, "light");
  await state(page, "PAUSED");
  const goal = await step(page), shown = String(goal).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
  await page.click("#tab-parameters");
  await page.$eval("#set-gravity", (input) => { input.value = "nonsense"; input.dispatchEvent(new Event("input")); });
  await page.click("#parameters .primary");
  await see(page, "Not set:", "a refusal is shown", "#notes");

  const killed = Date.now();
  console.log("do: kill");
  await state(page, "NOT CONNECTED");
  const missed = Date.now() - killed;
  hold(missed < NOTICED_MS, `a daemon that is killed is missed at once: ${missed} ms`);
  hold(await page.$eval("#go", (button) => button.disabled), "and nothing can be pressed meanwhile");
  const started = Date.now();
  console.log("do: start");
  await state(page, "RECOVERING");
  const found = Date.now() - started;
  hold(found < FOUND_MS, `one that comes back is found at once: ${found} ms`);
  await see(page, `of ${shown} ·`, "on its way back it says how far it goes", "#clock");
  await see(page, "back in", "and how long that takes yet", "#eta");
  const part = await page.$eval("#progress", (bar) => bar.value);
  hold(part > 0 && part < 1, `the bar shows it: ${part}`);
  hold(await text(page, "#notes") === "", "what the daemon before said is gone");
  await picture(page, "recovering");
  hold(await page.$eval("#stop", (button) => !button.disabled), "it can be stopped");
  await page.click("#stop");
  await page.waitForSelector("#ask[open]");
  await picture(page, "recovering-stop");
  hold(await page.$("#ask input") === null, "no checkpoint is offered there");
  await page.click("#ask .primary");
  await state(page, "EMPTY");
  await page.waitForFunction(() => document.querySelector("#notes").innerText.includes("Ended"), { timeout: PATIENCE_MS });
  hold(complaints.length === 0, `nothing goes wrong in the page: ${complaints}`);
  await endGateway();
} finally {
  await chromium.close();
  dropGateway();
}
