// The page in a browser. Whatever is done there, no request may leave the server, nothing may break the page's policy,
// and the console must stay free of errors.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { ROOT } from "./tool.mjs";

const puppeteer = createRequire(join(ROOT, "web/package.json"))("puppeteer-core");
const FLAGS = [
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];
const GPU = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];

const browsers = new Map();

/** A browser, with its software GPU or without one. */
async function browser(gpu) {
  if (!browsers.has(gpu)) {
    const userDataDir = mkdtempSync(join(tmpdir(), "echogrid-chromium-"));
    const executablePath = process.env.ECHOGRID_CHROMIUM ?? "/usr/bin/chromium";
    const args = [...FLAGS, ...(gpu ? GPU : ["--disable-gpu"])];
    browsers.set(gpu, {
      userDataDir,
      open: await puppeteer.launch({ executablePath, headless: true, args, userDataDir }),
    });
  }
  return browsers.get(gpu).open;
}

export async function closeBrowsers() {
  for (const { open, userDataDir } of browsers.values()) {
    await open.close();
    rmSync(userDataDir, { recursive: true, force: true, maxRetries: 5 });
  }
}

/**
 * Does something with the page of a server, then checks that it kept its manners. What `allow` matches may stand in the
 * console: a refusal that the test provokes.
 */
export async function visit(
  server,
  what,
  { width = 1280, height = 800, scheme = "light", gpu = false, ratio = 1, allow = /^$/ } = {},
) {
  const page = await (await browser(gpu)).newPage();
  const [asked, wrong] = [[], []];
  page.on("request", (request) => asked.push(request.url()));
  page.on("pageerror", (error) => wrong.push(`page: ${error.message}`));
  page.on("console", (m) => m.type() === "error" && wrong.push(`console: ${m.text()}`));
  await page.evaluateOnNewDocument(() => {
    window.broken = [];
    document.addEventListener("securitypolicyviolation", (e) =>
      window.broken.push(`${e.violatedDirective} ${e.blockedURI}`),
    );
  });
  await page.setViewport({ width, height, deviceScaleFactor: ratio });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  const hands = handsOn(page);
  await page.goto(server.address);
  await page.waitForFunction(() => window.echogrid !== undefined);
  await hands.ready();
  try {
    await what(hands);
    assert.deepEqual(
      wrong.filter((w) => !allow.test(w)),
      [],
      "no errors",
    );
    assert.deepEqual(await page.evaluate(() => window.broken), [], "the policy holds");
    const own = (url) => url.startsWith(`${new URL(server.address).origin}/`) || /^(blob|data):/.test(url);
    assert.deepEqual(
      asked.filter((url) => !own(url)),
      [],
      "nothing is asked elsewhere",
    );
  } finally {
    await page.close();
  }
}

/** What a user does, each with a wait until all of it is shown. */
function handsOn(page) {
  const ready = () => page.evaluate(() => window.echogrid.ready());
  const state = () => page.evaluate(() => window.echogrid.state());
  const then =
    (act) =>
    async (...args) => {
      const result = await act(...args);
      await ready();
      return result;
    };
  const open = (id) => page.$eval(id, (details) => (details.open = true));
  const text = (selector) => page.$eval(selector, (e) => e.innerText ?? e.textContent);
  const set = async (selector, value) => {
    await page.$eval(
      selector,
      (field, value) => {
        field.value = value;
        field.dispatchEvent(new Event("input", { bubbles: true }));
        field.dispatchEvent(new Event("change", { bubbles: true }));
      },
      String(value),
    );
    // What is typed is sent a moment later.
    if (!selector.includes("slider")) await new Promise((next) => setTimeout(next, 320));
  };
  return {
    page,
    ready,
    state,
    text,
    open: then(open),
    click: then((selector) => page.click(selector)),
    key: then((...keys) => press(page, keys)),
    set: then(set),
    select: then((selector, value) => page.select(selector, value)),
    position: async () => (await state()).state.position,
    /** Where on screen a cell's middle is. */
    place: async (column, row, canvas = "#canvas-0") => {
      const { viewport } = await state();
      const box = await (await page.$(canvas)).boundingBox();
      return [
        box.x + box.width / 2 + (column + 0.5 - viewport.centre[0]) * viewport.scale,
        box.y + box.height / 2 - (row + 0.5 - viewport.centre[1]) * viewport.scale,
      ];
    },
  };
}

/** `Shift+ArrowRight`: keys that are held, and the last one. */
async function press(page, keys) {
  for (const chord of keys) {
    const parts = chord === "+" ? ["+"] : chord.split("+");
    const last = parts.pop();
    for (const held of parts) await page.keyboard.down(held);
    await page.keyboard.press(last);
    for (const held of parts.reverse()) await page.keyboard.up(held);
  }
}
