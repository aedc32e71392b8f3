// Methods and parameters: changed, refused, two side by side with their difference.

import assert from "node:assert/strict";
import { test } from "node:test";
import { mapped } from "./lib/like.mjs";
import { visit } from "./lib/page.mjs";
import { shot } from "./lib/shot.mjs";
import { colours, differences, picture } from "./lib/tiles.mjs";
import { LOGS, serve } from "./lib/tool.mjs";

test("a parameter changes the map at once, a wrong one changes nothing and is explained", async () => {
  const log = LOGS.ring();
  const server = await serve(log, "-m", "bayes");
  await visit(
    server,
    async (page) => {
      await page.set("#slider", 80);
      await page.open("#lanes-details");
      const plain = await shot(page);
      await page.set("#set-0-epsilon", "0.2");
      await page.set("#set-0-beta", "8deg");
      const { sources, state } = await server.json("api/session");
      assert.deepEqual(sources[0].set, { beta: "8deg", epsilon: "0.2" });
      assert.equal(state.position, 80, "at the same place of the log");
      const set = ["epsilon=0.2", "beta=8deg"];
      const wanted = await mapped(server, log, "bayes", { until: 80, set });
      assert.equal(differences(await picture(server, "combined"), wanted), 0);
      const changed = await shot(page);
      assert.notEqual(changed.pixels, plain.pixels, "the page shows it");
      await page.set("#set-0-epsilon", "-1");
      assert.match(await page.text("#lanes-error"), /epsilon.*nothing was changed/s);
      assert.equal(await page.page.$eval("#set-0-epsilon", (f) => f.getAttribute("aria-invalid")), "true");
      assert.equal((await shot(page)).pixels, changed.pixels, "the map is as it was");
      await page.set("#set-0-epsilon", "");
      await page.set("#set-0-beta", "");
      assert.equal(await page.text("#lanes-error"), "");
      assert.equal((await shot(page)).pixels, plain.pixels, "defaults bring the first map back");
    },
    { allow: /status of 400/ },
  );
  server.close();
});

test("another method, at the same place of the log", async () => {
  const log = LOGS.ring();
  const server = await serve(log, "-m", "bayes");
  await visit(server, async (page) => {
    await page.set("#slider", 80);
    await page.open("#lanes-details");
    for (const method of ["himm", "certainty"]) {
      await page.select("#method-0", method);
      assert.equal(await page.position(), 80);
      assert.match(await page.text("figcaption"), new RegExp(`^${method} combined`));
      const wanted = await mapped(server, log, method, { until: 80 });
      assert.equal(differences(await picture(server, "combined"), wanted), 0, method);
    }
    assert.equal(await page.page.$("#set-0-max_occ"), null, "another method's parameters are gone");
    await page.select("#method-0", "csm-continuous");
    const { scan } = (await page.state()).state;
    assert.ok(Math.abs(scan - 80 / 6) < 3, `scan ${scan}`);
  });
  server.close();
});

test("two methods step together, and their difference is the second less the first", async () => {
  const log = LOGS.ring();
  const server = await serve(log, "-m", "certainty", "--beside", "bayes");
  await visit(server, async (page) => {
    await page.key("PageDown");
    const { lanes } = (await page.state()).state;
    assert.equal(lanes[0].position, lanes[1].position);
    assert.deepEqual((await page.state()).panels, [0, 1, "difference"]);
    const until = lanes[0].position;
    for (const [k, method] of ["certainty", "bayes"].entries()) {
      assert.equal(differences(await picture(server, "combined", k), await mapped(server, log, method, { until })), 0);
    }
    const less = await picture(server, "combined", "difference");
    assert.ok(colours(less) > 3);
    await page.key("m", "o");
    await page.click("#axes");
    const canvas = await shot(page, "#canvas-difference");
    const [first, second] = [await picture(server, "combined"), await picture(server, "combined", 1)];
    let [same, told] = [0, 0];
    for (let row = 2; row < less.height - 2; row += 5) {
      for (let column = 2; column < less.width - 2; column += 5) {
        same += canvas.cell(column, row) === less.at(column, row);
        told += 1;
        if (first.at(column, row) === second.at(column, row) && first.at(column, row) !== "#a8b4c4") {
          // Colours are coarser than values.
          assert.match(less.at(column, row), /^#f[8-f]f[8-f]f[8-f]$/, "where both agree it is white");
        }
      }
    }
    assert.equal(same, told);
    await page.open("#lanes-details");
    await page.click("#remove-lane");
    assert.deepEqual((await page.state()).panels, [0]);
    await page.click("#add-lane");
    await page.select("#method-1", "features");
    assert.match(await page.text('[data-source="1"] figcaption'), /^features/);
    await page.key("PageDown");
    const after = (await page.state()).state.lanes;
    assert.ok(after[0].current.line >= after[1].current.line, "no lane runs ahead in the log");
  });
  server.close();
});
