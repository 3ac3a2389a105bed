// SPDX-License-Identifier: BSD-3-Clause
// A dam of 10^5 particles, for test_dashboard.py, which has loaded it: points of about a pixel cover the fluid, and so do fewer that are larger.
import { complaints, dropGateway, endGateway, hold, holdSoon, launch, open, picture, see, startGateway } from "./page.mjs";

const WATER_OF_ALL = 2 * 1 / (5.366 * 2);

await startGateway();
const chromium = await launch();

try {
  const page = await open(chromium, "light");
  /** Pixels within the fluid: how many are of no fluid, which part is water, and where that ends in x and y, as parts of the whole. */
  const covered = async () => {
    await page.screenshot();
    return page.evaluate(() => {
      const from = document.querySelector("#canvas canvas"), to = document.createElement("canvas");
      [to.width, to.height] = [from.width, from.height];
      const pen = to.getContext("2d");
      pen.drawImage(from, 0, 0);
      const { data } = pen.getImageData(0, 0, to.width, to.height);
      const colours = [...document.querySelectorAll(".legend i")].map((dot) => dot.style.backgroundColor.match(/\d+/g).map(Number));
      const is = (x, y, colour) => colour.every((c, d) => Math.abs(c - data[4 * (y * to.width + x) + d]) < 12);
      const ends = [Infinity, -1, Infinity, -1], water = [...ends];
      const widen = (box, x, y) => box.splice(0, 4, Math.min(box[0], x), Math.max(box[1], x), Math.min(box[2], y), Math.max(box[3], y));
      for (let y = 0; y < to.height; y++)
        for (let x = 0; x < to.width; x++) {
          if (colours.some((colour) => is(x, y, colour))) widen(ends, x, y);
          if (is(x, y, colours[0])) widen(water, x, y);
        }
      const [x0, x1, y0, y1] = ends, EDGE = 2;
      let holes = 0, wet = 0, all = 0;
      for (let y = y0 + EDGE; y <= y1 - EDGE; y++)
        for (let x = x0 + EDGE; x <= x1 - EDGE; x++) {
          all++;
          wet += is(x, y, colours[0]);
          holes += !colours.some((colour) => is(x, y, colour));
        }
      return { all, holes, water: wet / all, right: (water[1] - x0) / (x1 - x0), high: (y1 - water[2]) / (y1 - y0) };
    });
  };
  await see(page, "All 107\u202f400 particles", "all particles are there", "#shown");
  for (const [wide, high] of [[1280, 800], [1536, 864], [1100, 700]]) {
    await page.setViewport({ width: wide, height: high });
    let seen;
    await holdSoon(async () => { seen = await covered(); return seen.all > 60000 && seen.holes === 0; }, `they cover the fluid without a hole in a window of ${wide} by ${high}`);
    hold(Math.abs(seen.right - 2 / 5.366) < 0.006 && Math.abs(seen.high - 0.5) < 0.01, `and the water ends where it does: ${JSON.stringify(seen)}`);
    await picture(page, `many-${wide}`);
  }
  await page.setViewport({ width: 1280, height: 800 });
  await page.select("#limit", "20000");
  await see(page, "Thinned:", "fewer are told", "#shown");
  let few;
  await holdSoon(async () => { few = await covered(); return few.all > 60000 && few.holes < 1e-4 * few.all; }, "they cover it too");
  hold(Math.abs(few.water / WATER_OF_ALL - 1) < 0.03, `and are as much water: ${JSON.stringify(few)}`);
  await picture(page, "few");
  hold(complaints.length === 0, `nothing goes wrong in the page: ${complaints}`);
  await endGateway();
} finally {
  await chromium.close();
  dropGateway();
}
