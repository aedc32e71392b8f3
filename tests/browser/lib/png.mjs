// Reads a PNG by its specification, independently of browser and server: 8 bits a sample or a palette of fewer, not
// interlaced, which is all that either writes here.

import { inflateSync } from "node:zlib";

const SIGNATURE = "89504e470d0a1a0a";
/** Samples of a pixel, by colour type. */
const SAMPLES = { 0: 1, 2: 3, 3: 1, 4: 2, 6: 4 };

function chunks(bytes) {
  if (bytes.subarray(0, 8).toString("hex") !== SIGNATURE) throw new Error("no PNG");
  const found = [];
  for (let at = 8; at < bytes.length;) {
    const length = bytes.readUInt32BE(at);
    found.push({ type: bytes.toString("latin1", at + 4, at + 8), data: bytes.subarray(at + 8, at + 8 + length) });
    at += length + 12;
  }
  return found;
}

function paeth(a, b, c) {
  const [pa, pb, pc] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/** Undoes each line's filter. */
function unfilter(raw, height, line, step) {
  const out = Buffer.alloc(height * line);
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (line + 1)];
    for (let x = 0; x < line; x++) {
      const a = x >= step ? out[y * line + x - step] : 0;
      const b = y > 0 ? out[(y - 1) * line + x] : 0;
      const c = x >= step && y > 0 ? out[(y - 1) * line + x - step] : 0;
      const add = [0, a, b, (a + b) >> 1, paeth(a, b, c)][filter];
      if (add === undefined) throw new Error(`there is no filter ${filter}`);
      out[y * line + x] = raw[y * (line + 1) + 1 + x] + add;
    }
  }
  return out;
}

/** Width, height, and the colour of a pixel as "#rrggbb", counted from the upper left. */
export function decode(bytes) {
  const all = chunks(Buffer.from(bytes));
  const part = (type) => all.find((c) => c.type === type)?.data;
  const head = part("IHDR");
  const [width, height, depth, kind] = [head.readUInt32BE(0), head.readUInt32BE(4), head[8], head[9]];
  if ((depth !== 8 && kind !== 3) || head[12] !== 0)
    throw new Error(`depth ${depth}, kind ${kind}, interlaced ${head[12]}`);
  const samples = SAMPLES[kind];
  const line = Math.ceil((width * samples * depth) / 8);
  const raw = inflateSync(Buffer.concat(all.filter((c) => c.type === "IDAT").map((c) => c.data)));
  const lines = unfilter(raw, height, line, Math.max(1, (samples * depth) >> 3));
  const palette = part("PLTE");
  const at = (x, y) => {
    if (x < 0 || y < 0 || x >= width || y >= height) throw new Error(`no pixel ${x}, ${y} in ${width} × ${height}`);
    if (kind === 3) {
      const entry = (lines[y * line + ((x * depth) >> 3)] >> (8 - depth - ((x * depth) & 7))) & ((1 << depth) - 1);
      return palette.subarray(3 * entry, 3 * entry + 3).toString("hex");
    }
    const from = y * line + x * samples;
    const grey = lines.subarray(from, from + 1).toString("hex");
    return samples < 3 ? grey.repeat(3) : lines.subarray(from, from + 3).toString("hex");
  };
  return { width, height, at: (x, y) => `#${at(x, y)}` };
}
