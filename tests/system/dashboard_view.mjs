// SPDX-License-Identifier: BSD-3-Clause
// The picture itself, for test_dashboard.py, which has loaded a small case in space and paused it: turned by mouse and keys,
// refused, in a browser that cannot draw it, on a page in the background.
import { PATIENCE_MS, complaints, dropGateway, endGateway, hold, holdSoon, launch, open, picture, pixels, see, startGateway } from "./page.mjs";

const WATER = [0x1f, 0x78, 0xb4];

await startGateway();
const chromium = await launch(), blind = await launch("--disable-3d-apis");

try {
  const plain = await open(blind, "light");
  await see(plain, "This browser cannot draw the particles", "a browser without WebGL says so", "#empty");
  hold(complaints.every((words) => words.includes("WebGL")), `and nothing else is wrong there: ${complaints}`);
  await plain.waitForFunction(() => document.querySelectorAll("figure .uplot").length > 0, { timeout: PATIENCE_MS });
  await plain.click("#tab-parameters");
  await see(plain, "end time", "it has charts and parameters", "#parameters");
  hold(await plain.$eval("#field", (select) => select.disabled), "what is for pictures only cannot be chosen");
  await plain.click("#step");
  await see(plain, "step 1 ", "its buttons work", "#clock");
  await picture(plain, "blind");

  // Browsers let the timers of a page in the background sleep.
  const asleep = await open(chromium, "light", (page) => page.evaluateOnNewDocument(() => { window.setInterval = () => 0; }));
  await asleep.waitForSelector("[data-state=PAUSED]", { timeout: PATIENCE_MS });
  await asleep.click("#lease-button");
  await asleep.waitForSelector("#ask[open]");
  await asleep.keyboard.press("Enter");
  await see(plain, "dashboard holds the lease, 1", "a page in the background has the lease", "#lease");
  const left = () => plain.$eval("#lease", (words) => Number(/(\d+) s/.exec(words.textContent)?.[1]));
  await holdSoon(async () => await left() <= 9, "which grows old");
  await holdSoon(async () => await left() >= 11, "and is renewed");
  await asleep.click("#lease-button");
  await asleep.close();

  const page = await open(chromium, "light");
  await see(page, "All 10\u202f800 particles", "a space has its particles", "#shown");
  await page.$eval("#field", (select) => { select.options[1].value = "no_such_field"; select.selectedIndex = 1; select.dispatchEvent(new Event("change")); });
  await see(page, "No picture: ", "a picture that the daemon refuses is told", "#shown");
  await page.select("#field", "phase");
  await see(page, " particles", "until another is wanted", "#shown");

  await page.waitForFunction(() => document.querySelectorAll("#probes .uplot").length > 10, { timeout: PATIENCE_MS });
  await holdSoon(async () => await pixels(page, WATER) > 500, "the water is blue");
  const seen = () => page.$eval("#canvas canvas", (canvas) => canvas.toDataURL()), first = await seen();
  await picture(page, "space");
  /** The picture changes from what it was. @param {() => Promise<void>} act */
  const changed = async (act, what) => {
    const was = await seen();
    await act();
    await holdSoon(async () => await seen() !== was, what);
    hold(await pixels(page, WATER) > 500, "and still shows the water");
  };
  const home = async () => {
    await page.keyboard.press("Home");
    await holdSoon(async () => await seen() === first, "Home brings the first picture back, to the pixel");
  };
  const { x, y, width, height } = await (await page.$("#canvas")).boundingBox();
  await changed(async () => {
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2 + 90, y + height / 2 - 40, { steps: 4 });
    await page.mouse.up();
  }, "a space is turned by the mouse");
  await picture(page, "space-turned");
  await page.focus("#canvas");
  await home();
  for (const key of ["ArrowLeft", "ArrowUp", "+"]) await changed(() => page.keyboard.press(key), `and by ${key}`);
  await home();

  /** Is nothing drawn at the edge of the picture? All lines of the box end within it then. */
  const isWhole = () => page.$eval("#canvas canvas", (from) => {
    const to = document.createElement("canvas");
    [to.width, to.height] = [from.width, from.height];
    const pen = to.getContext("2d");
    pen.drawImage(from, 0, 0);
    const { data } = pen.getImageData(0, 0, to.width, to.height), paper = data.slice(0, 3);
    const differs = (x, y) => paper.some((c, d) => data[4 * (y * to.width + x) + d] !== c);
    let drawn = 0, cut = 0;
    for (let y = 0; y < to.height; y++)
      for (let x = 0; x < to.width; x++) if (differs(x, y)) x && y && x < to.width - 1 && y < to.height - 1 ? drawn++ : cut++;
    return drawn > 500 && cut === 0;
  });
  for (const [wide, high] of [[1280, 800], [1536, 864], [375, 740], [1280, 560]]) {
    await page.setViewport({ width: wide, height: high });
    await holdSoon(async () => await page.screenshot() && await isWhole(), `all of the space is seen in a window of ${wide} by ${high}`);
    await picture(page, `space-${wide}`);
  }
  await page.setViewport({ width: 1280, height: 800 });

  const focus = () => page.evaluate(() => document.activeElement.id);
  for (const panel of ["probes", "events", "journal"]) {
    await page.focus(`#tab-${panel}`);
    await page.keyboard.press("Enter");
    await page.keyboard.press("Tab");
    hold(await focus() === panel, `${panel} can be reached without a mouse`);
  }
  await page.click("#tab-probes");
  await page.keyboard.press("Tab");
  await page.keyboard.press("PageDown");
  await holdSoon(() => page.$eval("#probes", (place) => place.scrollTop > 100), "and scrolled");
  await endGateway();
} finally {
  await chromium.close();
  await blind.close();
  dropGateway();
}
