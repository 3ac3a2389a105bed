// SPDX-License-Identifier: BSD-3-Clause
// A run that has stopped by itself: nothing is offered that the daemon refuses. See page.mjs.
import { spawnSync } from "node:child_process";
import path from "node:path";
import { PATIENCE_MS, complaints, dropGateway, endGateway, hold, launch, open, see, startGateway, state, text } from "./page.mjs";

const small = ["dambreak2d", "--set", "resolution=20", "--set", "end_time=0.1"];
function meniscus(...words) {
  const done = spawnSync(path.resolve(process.argv[2], "meniscus"), words, { encoding: "utf8" });
  if (done.status) throw new Error(`meniscus ${words.join(" ")}: ${done.stderr}`);
}
const may = (page, id) => page.$eval(id, (button) => !button.disabled);

await startGateway();
const chromium = await launch();
try {
  const page = await open(chromium, "light");
  meniscus("load", ...small, "--set", "limits.density_max=1.0001", "--set", "gravity=[0, -100]");
  meniscus("start");
  await state(page, "FAULT");
  await see(page, "press Go back, to the beginning, as there is no checkpoint.", "what to do is said with the name of the button", "#banner");
  const banner = await text(page, "#banner");
  hold(/\. What to do: /.test(banner) && !/restore|reset/.test(banner), `after the end of a sentence: ${banner}`);
  hold(!await may(page, "#go") && !await may(page, "#checkpoint") && await may(page, "#snapshot"), "what would be refused cannot be clicked");
  await page.click("#back");
  await page.waitForSelector("#ask[open]");
  hold((await page.$$eval("#ask input", (all) => all.map((input) => `${input.value} ${input.checked}`))).join() === "reset true", "no checkpoint is offered where there is none");
  await page.click("#ask .primary");
  await state(page, "READY");

  meniscus("load", ...small, "--set", 'gravity=["sqrt(0.02 - t)", -1]');
  meniscus("start");
  await state(page, "FAULT");
  await see(page, "set another gravity under Parameters, then press Resume.", "a formula can be changed", "#banner");
  hold(await may(page, "#go") && await may(page, "#checkpoint"), "and its run can go on");
  meniscus("set", "gravity=[0, -1]");
  await state(page, "PAUSED");
  await page.click("#go");
  await state(page, "DONE");

  const title = "A very long title that says what is seen, of which water, in which tank, and for whom it was made, as titles of studies do; ".repeat(2).trim().slice(0, 240);
  meniscus("load", ...small, "--set", `title=${title}`);
  await see(page, "A very long title", "a long title comes", "#title");
  await page.setViewport({ width: 360, height: 700 });
  const head = await page.$eval("#title", (h1) => ({ title: h1.title, lines: h1.clientHeight / parseFloat(getComputedStyle(h1).lineHeight), cut: h1.scrollHeight > h1.clientHeight, clamp: getComputedStyle(h1).webkitLineClamp }));
  hold(head.lines < 2.2 && head.cut && head.clamp === "2" && head.title === title, `and has two lines and an ellipsis at most, all of it in its tooltip: ${JSON.stringify(head)}`);
  hold(await page.$eval("header", (header) => header.clientHeight) < 130, "so that the header leaves room for the picture");
  meniscus("load", ...small, "--set", 'title="dam\\nbreak \\u202egpj.exe"');
  await see(page, "dam\\nbreak \\u202egpj.exe", "what cannot be seen in a title is shown as its escape", "#title");
  meniscus("stop");
  await state(page, "EMPTY");
  await see(page, "No case is loaded", "that no case is loaded is said", "#empty");
  await new Promise((resolve) => setTimeout(resolve, 1500)); // a picture may be asked for meanwhile
  hold(await text(page, "#shown") === "", "and no second time in other words");
  hold(complaints.length === 0, `nothing goes wrong in the page: ${complaints}`);
  await endGateway();
} finally {
  await chromium.close();
  dropGateway();
}
