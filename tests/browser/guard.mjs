// Who is let in: nobody without the token, no other site's page, nobody under a stranger's name.

import assert from "node:assert/strict";
import { request } from "node:http";
import { test } from "node:test";
import { visit } from "./lib/page.mjs";
import { LOGS, serve } from "./lib/tool.mjs";

/** The status of a request with such headers, which fetch would not send. */
const status = (url, headers = {}, method = "GET", body = "") =>
  new Promise((found, failed) => {
    const asked = request(url, { method, headers }, (answer) => {
      answer.resume();
      answer.on("end", () => found(answer.statusCode));
    });
    asked.on("error", failed);
    asked.end(body);
  });

test("a wrong token opens neither the page nor the server's answers", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  const token = new URL(server.address).pathname.slice(1, -1);
  assert.match(token, /^[0-9a-f]{32}$/);
  const wrong = token.replace(/^./, (c) => (c === "0" ? "1" : "0"));
  for (const path of ["", "view.js", "api/session", "api/tile?source=0&view=combined&level=0&column=0&row=0"]) {
    assert.equal(await status(server.address.replace(token, wrong) + path), 403, path);
  }
  assert.equal(await status(new URL(server.address).origin + "/"), 403);
  assert.equal(await status(new URL("/api/session", server.address)), 403);
  assert.equal(await status(server.address + "api/session"), 200);
  await visit(
    server,
    async ({ page }) => {
      const answer = await page.goto(server.address.replace(token, wrong));
      assert.equal(answer.status(), 403);
      assert.match(await page.evaluate(() => document.body.innerText), /open the whole address/);
      assert.ok(!(await answer.text()).includes("<script"));
      await page.goto(server.address);
    },
    { allow: /status of 403/ },
  );
  server.close();
});

test("the token alone does not do for another site, another name, or a form", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  const session = server.address + "api/session";
  assert.equal(await status(session, { origin: "http://example.org" }), 403);
  assert.equal(await status(session, { "sec-fetch-site": "cross-site" }), 403);
  assert.equal(await status(session, { host: "example.org" }), 403);
  assert.equal(await status(session, { origin: new URL(server.address).origin }), 200);
  const go = (type) => status(server.address + "api/go", { "content-type": type }, "POST", '{"to":5}');
  assert.equal(await go("text/plain"), 415);
  assert.equal((await server.json("api/session")).state.position, 0);
  assert.equal(await go("application/json"), 200);
  assert.equal((await server.json("api/session")).state.position, 5);
  server.close();
});

test("the page may load nothing but its own, and says so", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  const answer = await fetch(server.address);
  const policy = answer.headers.get("content-security-policy");
  for (const part of ["default-src 'none'", "script-src 'self'", "frame-ancestors 'none'"])
    assert.ok(policy.includes(part));
  assert.equal(answer.headers.get("referrer-policy"), "no-referrer");
  assert.equal(answer.headers.get("x-content-type-options"), "nosniff");
  const html = await answer.text();
  assert.doesNotMatch(html, /https?:|style="|<style|\son\w+="/);
  server.close();
});

test("a server that has gone is told, and the page stays", async () => {
  const server = await serve(LOGS.ring(), "-m", "bayes");
  await visit(
    server,
    async ({ key, text }) => {
      server.close();
      await new Promise((next) => setTimeout(next, 300));
      await key("ArrowRight");
      assert.match(await text("#error"), /the server does not answer/);
    },
    { allow: /ERR_CONNECTION_/ },
  );
});
