// Builds dist/ from src/. The same inputs give the same bytes: a test compares them with what is committed. A folder as
// an argument is written instead of dist/.
import { build } from "esbuild";
import { copyFile, mkdir } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");
await mkdir(out, { recursive: true });
await build({
  absWorkingDir: here,
  entryPoints: { view: "src/main.ts" },
  outdir: out,
  bundle: true,
  minify: true,
  target: "es2022",
  format: "iife",
  charset: "utf8",
  legalComments: "none",
});
await build({
  absWorkingDir: here,
  entryPoints: { view: "src/view.css" },
  outdir: out,
  minify: true,
  charset: "utf8",
  target: "es2022",
});
await copyFile(join(here, "src/index.html"), join(out, "index.html"));
