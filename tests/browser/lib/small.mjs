// A smaller PNG of a screenshot: a palette of its commonest colours.

import { deflateSync } from "node:zlib";

const COLOURS = 256;

/** A chunk's checksum; Node.js before 22 has none of its own. */
function crc32(bytes) {
  let sum = ~0;
  for (const byte of bytes) {
    sum ^= byte;
    for (let k = 0; k < 8; k++) sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
  }
  return ~sum >>> 0;
}

const chunk = (type, data) => {
  const body = Buffer.concat([Buffer.from(type, "latin1"), data]);
  const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
  length.writeUInt32BE(data.length);
  sum.writeUInt32BE(crc32(body));
  return Buffer.concat([length, body, sum]);
};

/** The commonest colours, no two of them nearly alike. */
function palette(counts) {
  const chosen = [];
  const byCount = [...counts].sort((a, b) => b[1] - a[1]).map(([colour]) => colour);
  for (const apart of [300, 60, 0]) {
    for (const colour of byCount) {
      if (chosen.length === COLOURS) return chosen;
      if (!chosen.some((c) => distance(c, colour) <= apart)) chosen.push(colour);
    }
  }
  return chosen;
}

function distance(a, b) {
  const part = (shift) => ((a >> shift) & 255) - ((b >> shift) & 255);
  return part(16) ** 2 + part(8) ** 2 + part(0) ** 2;
}

/** From a decoded picture. */
export function encode({ width, height, at }) {
  const pixels = new Uint32Array(width * height);
  const counts = new Map();
  for (let k = 0; k < pixels.length; k++) {
    pixels[k] = parseInt(at(k % width, Math.floor(k / width)).slice(1), 16);
    counts.set(pixels[k], (counts.get(pixels[k]) ?? 0) + 1);
  }
  const colours = palette(counts);
  const entry = new Map();
  for (const colour of counts.keys()) {
    const nearest = colours.reduce(
      (best, c, k) => (distance(c, colour) < distance(colours[best], colour) ? k : best),
      0,
    );
    entry.set(colour, nearest);
  }
  const lines = Buffer.alloc(height * (width + 1));
  pixels.forEach((colour, k) => (lines[Math.floor(k / width) * (width + 1) + 1 + (k % width)] = entry.get(colour)));
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 3, 0, 0, 0], 8);
  return Buffer.concat([
    Buffer.from("89504e470d0a1a0a", "hex"),
    chunk("IHDR", head),
    chunk("PLTE", Buffer.from(colours.flatMap((c) => [(c >> 16) & 255, (c >> 8) & 255, c & 255]))),
    chunk("IDAT", deflateSync(lines, { level: 9 })),
    chunk("IEND", Buffer.alloc(0)),
  ]);
}
