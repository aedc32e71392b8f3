// The browser's own GPU: every kernel gives the server's cells, the page says so, and a difference would be seen.

import assert from "node:assert/strict";
import { test } from "node:test";
import { visit } from "./lib/page.mjs";
import { differences, picture } from "./lib/tiles.mjs";
import { LOGS, serve } from "./lib/tool.mjs";

const METHODS = [
  ["certainty", LOGS.ring],
  ["bayes", LOGS.ring],
  ["dempster-shafer", LOGS.ring],
  ["himm", LOGS.ring],
  ["truth", LOGS.laser],
  ["features", LOGS.dense],
];

/** The numbers of the comparison, by name; for each lane. */
const checks = (page) =>
  page.page.$$eval("#gpu-check dl", (all) =>
    all.map((list) =>
      Object.fromEntries([...list.querySelectorAll("dt")].map((dt) => [dt.innerText, dt.nextSibling.innerText])),
    ),
  );

for (const [method, log] of METHODS) {
  test(`${method} on the browser's GPU: every cell is the server's`, async (t) => {
    const server = await serve(log(), "-m", method);
    await visit(
      server,
      async (page) => {
        if (await page.page.$eval("#gpu", (box) => box.disabled)) return t.skip("this browser has no software GPU");
        await page.open("#compute-details");
        await page.key("PageDown", "g");
        assert.match(await page.text("#backend"), /^WebGPU: /);
        await page.key("End", "ArrowLeft");
        assert.equal(await page.text("#gpu-why"), "");
        const [check] = await checks(page);
        assert.ok(Number(check["tiles compared"].replace(",", "")) > 10);
        assert.equal(check["membership differences"], "0");
        assert.equal(check["value differences"], "0");
        const own = await picture(server, "combined", 0, "&backend=webgpu");
        assert.equal(differences(own, await picture(server, "combined")), 0);
        await page.key("g");
        assert.equal(await page.text("#backend"), "server CPU");
      },
      { gpu: true },
    );
    server.close();
  });
}

test("two lanes on the browser's GPU, a changed parameter, and a method that can't", async (t) => {
  const server = await serve(LOGS.ring(), "-m", "certainty", "--beside", "bayes");
  await visit(
    server,
    async (page) => {
      if (await page.page.$eval("#gpu", (box) => box.disabled)) return t.skip("this browser has no software GPU");
      await page.open("#compute-details");
      await page.open("#lanes-details");
      await page.key("g", "PageDown");
      assert.deepEqual((await page.state()).computed.map(String).sort(), ["0", "1", "difference"]);
      await page.set("#set-1-epsilon", "0.1");
      const both = await checks(page);
      assert.deepEqual(
        both.map((c) => c["membership differences"]),
        ["0", "0"],
      );
      assert.deepEqual(
        both.map((c) => c["value differences"]),
        ["0", "0"],
      );
      await page.select("#method-1", "csm-continuous");
      assert.match(await page.text("#gpu-check"), /Server CPU: .*nearest poses/);
      assert.match(await page.text("#backend"), /^WebGPU: /, "the other lane still is");
    },
    { gpu: true },
  );
  server.close();
});

test("words that differ are counted, and drawn where they are asked for", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await server.json("api/go", { to: 20 });
  const { tile_words } = await server.json("api/gpu/plan?lane=0");
  const file = Buffer.from(await (await server.ask("api/gpu/batch?lane=0&from=0&to=20")).arrayBuffer());
  const told = JSON.parse(file.toString("utf8", 4, 4 + file.readUInt32LE(0)));
  const [{ place, slots }] = told.chunks;
  // A tile of zeros, as if no reading had come there.
  const words = new Uint32Array([1, ...place, slots[0], ...new Array(tile_words).fill(0)]);
  const found = await server.json("api/gpu/words?lane=0&to=20&more=1", new Uint8Array(words.buffer));
  assert.equal(found.tiles, 1);
  assert.equal(found.cells, 256);
  assert.ok(found.membership_differences > 0, "what is missing is told");
  const last = await server.json("api/gpu/words?lane=0&to=20", new Uint8Array(new Uint32Array([0]).buffer));
  assert.ok(last.tiles > 0 && last.membership_differences > 0, "and so is what was never sent");
  const own = await picture(server, "combined", 0, "&backend=webgpu");
  assert.ok(differences(own, await picture(server, "combined")) > 0);
  await assert.rejects(server.json("api/gpu/words?lane=0&to=19", new Uint8Array(words.buffer)), /position 19/);
  server.close();
});

test("without a GPU the switch is off, and says why", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await visit(server, async (page) => {
    await page.open("#compute-details");
    assert.equal(await page.page.$eval("#gpu", (box) => box.disabled), true);
    assert.match(await page.text("#gpu-why"), /no WebGPU adapter/);
    await page.key("g");
    assert.equal(await page.text("#backend"), "server CPU");
    assert.match(await page.text("#live"), /no WebGPU adapter/, "the key says why, too");
  });
  server.close();
});

test("the key is kept until the adapter is known", async (t) => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await visit(
    server,
    async (page) => {
      if (await page.page.$eval("#gpu", (box) => box.disabled)) return t.skip("this browser has no software GPU");
      await page.page.evaluateOnNewDocument(() => {
        const ask = GPU.prototype.requestAdapter;
        GPU.prototype.requestAdapter = async function (...how) {
          await new Promise((next) => setTimeout(next, 600));
          return ask.apply(this, how);
        };
      });
      await page.page.reload();
      await page.page.waitForFunction(() => window.echogrid !== undefined);
      assert.equal(await page.page.$eval("#gpu", (box) => box.disabled), true, "not known yet");
      await page.key("g");
      assert.match(await page.text("#backend"), /^WebGPU: /);
    },
    { gpu: true },
  );
  server.close();
});
