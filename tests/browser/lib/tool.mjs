// The binary under test: its runs, its servers, and the logs and maps that the tests look at, each made once.

import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

export const ROOT = resolve(import.meta.dirname ?? new URL(".", import.meta.url).pathname, "../../..");
const BINARY = process.env.ECHOGRID_BIN ?? join(ROOT, "target/release/echogrid");

const folder = mkdtempSync(join(tmpdir(), "echogrid-view-"));
const running = new Set();

/** A path in the tests' own folder. */
export const inside = (name) => join(folder, name);

/** Ends every server, and removes what was written. */
export function clean() {
  for (const server of running) server.kill();
  rmSync(folder, { recursive: true, force: true });
}

/** Runs the binary; what it says on standard error is part of the error where it fails. */
export function run(...args) {
  return execFileSync(BINARY, args, { cwd: ROOT, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
}

const made = new Map();
const once = (name, make) => {
  if (!made.has(name)) {
    make(inside(name));
    made.set(name, inside(name));
  }
  return made.get(name);
};

/** A simulated log. */
export const log = (world, rig, scans) =>
  once(`${world}-${rig}-${scans}.jsonl`, (path) =>
    run("simulate", `worlds/${world}.toml`, "--rig", rig, "--scans", String(scans), "-o", path, "--quiet"),
  );

/** A map of a log. */
export const map = (name, path, ...args) =>
  once(name, (out) => run("map", path, "-o", out, "--backend", "cpu", "--quiet", ...args));

export const LOGS = {
  /** 117 readings of eight sonars, many without echo. */
  ring: () => log("cartons", "ring8", 20),
  /** 1200 readings, for features. */
  dense: () => log("cartons", "dense", 6),
  laser: () => log("turned", "laser", 2),
};

/** A real log, if its folder is there; else that is said aloud. */
export function real() {
  const path = join(process.env.ECHOGRID_DATA ?? join(ROOT, "../shared/data"), "sonar_ring_8/test1");
  if (existsSync(path)) return path;
  process.stderr.write(`SKIPPED the_page_works_in_a_browser: no ${path} (set ECHOGRID_DATA to the folder of real logs)\n`);
  return null;
}

/** Serves a log or a map: the page's address, and questions to the server behind the page's back. */
export async function serve(...args) {
  const process = spawn(BINARY, ["view", ...args], { cwd: ROOT, stdio: ["ignore", "pipe", "pipe"] });
  running.add(process);
  let [said, complained] = ["", ""];
  process.stderr.on("data", (data) => (complained += data));
  const address = await new Promise((found, failed) => {
    process.stdout.on("data", (data) => {
      said += data;
      if (said.includes("\n")) found(said.split("\n")[0].trim());
    });
    process.on("exit", (code) =>
      failed(new Error(`echogrid view ${args.join(" ")} ended with ${code}: ${complained}`)),
    );
  });
  const ask = async (path, body) => {
    const headers = { "content-type": body instanceof Uint8Array ? "application/octet-stream" : "application/json" };
    const sent = body instanceof Uint8Array ? body : JSON.stringify(body);
    const answer = await fetch(address + path, body === undefined ? {} : { method: "POST", headers, body: sent });
    if (!answer.ok) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
    return answer;
  };
  return {
    address,
    ask,
    json: async (path, body) => (await ask(path, body)).json(),
    close: () => {
      running.delete(process);
      process.kill();
    },
  };
}
