// Bytes on their way to the GPU and back: the file of a batch, and what is read from buffers.

import type { GpuBatch } from "./generated/protocol";

export interface Batch {
  header: GpuBatch;
  /** The file, and where its first buffer begins. */
  file: ArrayBuffer;
  start: number;
}

export function parse(file: ArrayBuffer): Batch {
  const bytes = new DataView(file).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(file, 4, bytes));
  return { header: JSON.parse(text) as GpuBatch, file, start: 4 + bytes };
}

/** Some bytes of a buffer. */
export interface Piece {
  from: GPUBuffer;
  at: number;
  bytes: number;
}

/** Bytes of a request at most. */
const LARGEST = 32 << 20;

/** Tiles in requests that are not too large. */
export function posts<T>(tiles: T[], bytes: number): T[][] {
  // With each tile go three numbers, with all of them their count.
  const most = Math.max(1, Math.floor((LARGEST - 4) / (bytes + 12)));
  return Array.from({ length: Math.ceil(tiles.length / most) }, (_, k) => tiles.slice(k * most, (k + 1) * most));
}

/** The bytes of some pieces of buffers, one after the other, behind a head. */
export async function read(
  device: GPUDevice,
  spans: Piece[],
  head = new Uint8Array(),
): Promise<Uint8Array<ArrayBuffer>> {
  const total = spans.reduce((sum, s) => sum + s.bytes, head.length);
  const out = new Uint8Array(total);
  out.set(head);
  // Few bytes at a time: a buffer that is mapped has a limit too.
  const most = Math.min(64 << 20, device.limits.maxBufferSize);
  for (let k = 0, at = head.length; k < spans.length;) {
    const taken: Piece[] = [];
    let bytes = 0;
    for (let s = spans[k]; s && (bytes === 0 || bytes + s.bytes <= most); s = spans[++k]) {
      taken.push(s);
      bytes += s.bytes;
    }
    if (!bytes) continue;
    const staging = device.createBuffer({
      label: "read",
      size: bytes,
      usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST,
    });
    const encoder = device.createCommandEncoder({ label: "read" });
    let to = 0;
    for (const s of taken) {
      encoder.copyBufferToBuffer(s.from, s.at, staging, to, s.bytes);
      to += s.bytes;
    }
    device.queue.submit([encoder.finish()]);
    await staging.mapAsync(GPUMapMode.READ);
    out.set(new Uint8Array(staging.getMappedRange()), at);
    staging.destroy();
    at += bytes;
  }
  return out;
}
