// SPDX-License-Identifier: BSD-3-Clause
// For bench_pictures.py: what the dashboard's page computes for a picture, in headless Chromium. Arguments: the build directory, the gateway's port,
// for how many seconds. Prints one JSON line.
import { createRequire } from "node:module";
import path from "node:path";

const [build, port, seconds] = process.argv.slice(2);
const { default: puppeteer } = await import(createRequire(path.join(build, "web-check/node_modules/x.js")).resolve("puppeteer-core"));
const chromium = await puppeteer.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
try {
  const page = await chromium.newPage(), cdp = await page.createCDPSession();
  let pictures = 0;
  await cdp.send("Network.enable");
  cdp.on("Network.webSocketFrameReceived", ({ response }) => { pictures += response.opcode === 2 ? 1 : 0; });
  await page.goto(`http://127.0.0.1:${port}/`);
  await page.waitForFunction(() => document.querySelector("#shown").innerText.includes("particles"), { timeout: 30000 });
  await page.select("#field", "pressure");
  await page.$eval("#limit", (select) => { select.selectedIndex = 2; select.dispatchEvent(new Event("change")); }); // all of them
  await new Promise((resolve) => setTimeout(resolve, 2000));
  const before = await page.metrics(), begun = pictures, began = Date.now();
  await new Promise((resolve) => setTimeout(resolve, 1e3 * seconds));
  const after = await page.metrics(), n = pictures - begun;
  console.log(JSON.stringify({
    chromium_pictures_per_s: Number((1e3 * n / (Date.now() - began)).toFixed(1)),
    page_script_ms_per_picture: Number((1e3 * (after.ScriptDuration - before.ScriptDuration) / n).toFixed(2)),
  }));
} finally {
  await chromium.close();
}
