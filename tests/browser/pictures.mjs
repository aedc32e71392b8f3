// Draws docs/pictures/view-*.png: node tests/browser/pictures.mjs.

import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { closeBrowsers, visit } from "./lib/page.mjs";
import { decode } from "./lib/png.mjs";
import { encode } from "./lib/small.mjs";
import { ROOT, clean, log, map, real, serve } from "./lib/tool.mjs";

const out = process.argv[2] ?? join(ROOT, "docs/pictures");
const SIZE = { width: 1240, height: 700 };

const shoot = async (page, name, options = {}) => {
  await page.ready();
  const bytes = await page.page.screenshot(options);
  writeFileSync(join(out, `view-${name}.png`), encode(decode(bytes)));
};

/** Brings a place of the world near, into the middle. */
async function near(page, server, [x, y], times) {
  const { x0, y0, resolution } = (await server.json("api/session")).grid;
  for (let k = 0; k < times; k++) {
    await page.page.mouse.move(...(await page.place((x - x0) / resolution, (y - y0) / resolution)));
    await page.page.mouse.wheel({ deltaY: -184 });
    await page.ready();
  }
  const canvas = await (await page.page.$("#canvas-0")).boundingBox();
  await page.page.mouse.down();
  await page.page.mouse.move(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2, { steps: 3 });
  await page.page.mouse.up();
  await page.page.mouse.move(0, 0);
}

const panels = async (page) => ({ clip: await (await page.page.$("#panels")).boundingBox() });

async function oneMethod(path) {
  const server = await serve(path, "-m", "certainty");
  await visit(
    server,
    async (page) => {
      await page.set("#slider", 1300);
      await page.key("3");
      await shoot(page, "combined");
      await page.key("End", "1");
      await shoot(page, "empty", await panels(page));
      await page.key("2");
      await shoot(page, "full", await panels(page));
      await page.key("Home");
      await page.set("#slider", 1300);
      // An echo in the middle of the corridor.
      const echo = async () => {
        const { current } = (await page.state()).state.lanes[0];
        return current.outcome === "hit" && current.range > 0.9;
      };
      for (let k = 0; k < 40 && !(await echo()); k++) await page.key("ArrowRight");
      const { pose, range } = (await page.state()).state.lanes[0].current;
      await page.key("4");
      await page.select("#step", "normalised");
      const half = range / 2;
      await near(page, server, [pose[0] + half * Math.cos(pose[2]), pose[1] + half * Math.sin(pose[2])], 4);
      const { column, row, region } = await server.json("api/working?lane=0");
      const arc = region.indexOf(1);
      await page.page.mouse.click(...(await page.place(column[arc], row[arc])));
      await page.open("#history-details");
      await page.page.mouse.move(0, 0);
      await shoot(page, "working");
    },
    SIZE,
  );
  server.close();
}

async function twoMethods(path) {
  const server = await serve(path, "-m", "certainty", "--beside", "dempster-shafer");
  await visit(
    server,
    async (page) => {
      await page.key("End");
      await shoot(page, "two", await panels(page));
    },
    SIZE,
  );
  server.close();
}

async function features() {
  const server = await serve(log("cartons", "dense", 60), "-m", "features");
  await visit(
    server,
    async (page) => {
      await page.set("#slider", 6300);
      const wanted = async () => {
        const { case: made } = (await page.state()).state.lanes[0].current;
        return made.name === "associated" && made.parts.length > 0;
      };
      for (let k = 0; k < 200 && !(await wanted()); k++) await page.key("ArrowRight");
      const { pose } = (await page.state()).state.lanes[0].current;
      await page.open("#reading-details");
      await page.page.$eval("#cell-details", (d) => (d.open = false));
      await near(page, server, [pose[0], pose[1]], 4);
      await shoot(page, "features");
    },
    SIZE,
  );
  server.close();
}

async function errors() {
  const path = log("cartons", "dense", 60);
  const server = await serve(map("cartons", path, "-m", "bayes"), "--truth", "worlds/cartons.toml");
  await visit(
    server,
    async (page) => {
      await page.click('[data-view="levels"]');
      await page.page.$eval("#score-details", (d) => (d.open = false));
      await page.page.$eval("#compare-details", (d) => (d.open = false));
      await shoot(page, "errors");
    },
    SIZE,
  );
  server.close();
}

try {
  const path = real() ?? log("bend", "ring8", 200);
  await oneMethod(path);
  await twoMethods(path);
  await features();
  await errors();
} finally {
  await closeBrowsers();
  clean();
}
