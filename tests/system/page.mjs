// SPDX-License-Identifier: BSD-3-Clause
// What tests of the page share: a gateway, headless Chromium, and words for what is seen there. Arguments: the build directory, a directory for
// pictures. The environment leads to the daemon. One line for each fact; the first that does not hold ends it.
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { once } from "node:events";
import { writeFileSync } from "node:fs";
import path from "node:path";

const [build, pictures] = process.argv.slice(2).map((word) => path.resolve(word));
const { default: puppeteer } = await import(createRequire(path.join(build, "web-check/node_modules/x.js")).resolve("puppeteer-core"));
export const PATIENCE_MS = 20000;
/** What went wrong in the pages, and what they asked others for. */
export const complaints = [], elsewhere = [];
let port = "0", address = "", gateway;

/** As it comes; once more at the same address, with the same word. */
export async function startGateway() {
  const word = path.join(pictures, "token"), again = address ? ["--http-token", word] : [];
  if (address) writeFileSync(word, token(), { mode: 0o600 });
  gateway = spawn(path.join(build, "meniscus-dashboard"), ["--http", port, ...again], { stdio: ["ignore", "ignore", "pipe"] });
  for await (const line of gateway.stderr) {
    const found = /http:\/\/127\.0\.0\.1:(\d+)\/\S*/.exec(String(line));
    if (!found) continue;
    port = found[1];
    address ||= found[0];
    return;
  }
  throw new Error("the gateway did not start");
}

export async function endGateway() {
  const ended = once(gateway, "exit");
  gateway.kill("SIGTERM");
  const [code] = await ended;
  hold(code === 0, "the gateway ends when it is told to");
}

/** At the end of it all, however that came. */
export function dropGateway() {
  gateway.kill("SIGKILL");
}

export function hold(fact, what) {
  if (!fact) throw new Error(`not so: ${what}`);
  console.log(`so: ${what}`);
}

/** What is drawn comes with the next picture of the screen. @param {() => Promise<boolean>} fact */
export async function holdSoon(fact, what) {
  for (const end = Date.now() + PATIENCE_MS; Date.now() < end && !await fact();) await new Promise((resolve) => setTimeout(resolve, 100));
  hold(await fact(), what);
}

/** @param {string[]} more  options of the browser */
export function launch(...more) {
  return puppeteer.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...more] });
}

export const token = () => new URL(address).hash.slice("#token=".length);

/** The page in a browser of its own, as it were. @param {boolean} known  whether it knows the token */
export async function open(chromium, scheme, prepare = async () => {}, known = true) {
  const context = await chromium.createBrowserContext(), page = await context.newPage();
  await page.setViewport({ width: 1280, height: 800 });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("request", (request) => request.url().startsWith(`http://127.0.0.1:${port}/`) || request.url().startsWith("data:") || elsewhere.push(request.url()));
  await prepare(page);
  await page.goto(known ? address : new URL("/", address).href);
  return page;
}

export async function see(page, words, what = words, where = "body") {
  await page.waitForFunction((w, at) => document.querySelector(at)?.innerText.includes(w), { timeout: PATIENCE_MS, polling: 50 }, words, where)
    .catch(async () => { throw new Error(`does not come: ${what}; the page says: ${await page.$eval("body", (b) => b.innerText)}`); });
  console.log(`so: ${what}`);
}
export const state = (page, name) => see(page, name, `the page says ${name}`, "#state");
export const text = (page, selector) => page.$eval(selector, (element) => element.textContent);
export const step = async (page) => Number(/step ([\d\u202f]+)/.exec(await text(page, "#clock"))[1].replaceAll("\u202f", ""));
export const picture = (page, name) => page.screenshot({ path: path.join(pictures, `${name}.png`) });

/** How many pixels of the particles are nearly of this colour. */
export async function pixels(page, colour) {
  await page.screenshot(); // a browser without a screen may put off drawing until somebody looks, where processors are busy
  return page.evaluate((wanted) => {
    const from = document.querySelector("#canvas canvas"), to = document.createElement("canvas");
    [to.width, to.height] = [from.width, from.height];
    const pen = to.getContext("2d");
    pen.drawImage(from, 0, 0);
    const { data } = pen.getImageData(0, 0, to.width, to.height);
    let n = 0;
    for (let k = 0; k < data.length; k += 4) n += wanted.every((c, i) => Math.abs(c - data[k + i]) < 12);
    return n;
  }, colour);
}
