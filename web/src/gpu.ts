// A lane's map, computed by the browser's own GPU with the project's own kernels: no more than buffers and dispatches,
// in the order that the server's plan gives. No part of the page is known here.

import { api } from "./api";
import type { GpuBatch, GpuCheck, GpuChunk, GpuPlan, GpuShader, Span } from "./protocol";

/** Readings in a batch, at most. */
const PIECE = 4096;
/** Bytes of the smallest buffer: a kernel's arrays want an element at least. */
const SMALLEST = 256;
/** Threads of a group that sums. */
const SUMMED = 64;

/** Where cells are compared with the server's, what came out. */
export interface Check {
  tiles: number;
  cells: number;
  membership: number;
  values: number;
  largest: number;
}

/** An adapter's device, with the largest buffers that it gives. */
export interface Opened {
  device: GPUDevice;
  name: string;
}

/** Opens the browser's GPU; throws in words where there is none. */
export async function open(): Promise<Opened> {
  if (!("gpu" in navigator)) throw new Error("this browser has no WebGPU");
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
  if (!adapter) throw new Error("this browser's WebGPU finds no adapter");
  const { maxStorageBufferBindingSize, maxBufferSize } = adapter.limits;
  const device = await adapter.requestDevice({
    label: "echogrid",
    requiredLimits: { maxStorageBufferBindingSize, maxBufferSize },
  });
  const { vendor, architecture, device: model, description } = adapter.info;
  const name = description || [vendor, architecture, model].filter(Boolean).join(" ") || "an adapter without a name";
  return { device, name };
}

interface Batch {
  told: GpuBatch;
  /** The file, and where its first buffer begins. */
  file: ArrayBuffer;
  start: number;
}

function parse(file: ArrayBuffer): Batch {
  const bytes = new DataView(file).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(file, 4, bytes));
  return { told: JSON.parse(text) as GpuBatch, file, start: 4 + bytes };
}

function decode(base64: string): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
}

/** One lane. */
export class Runner {
  /** The readings that its map holds. */
  position = 0;
  private plan: GpuPlan | null = null;
  private quitting = false;
  private readonly chunks = new Map<string, GPUBuffer>();
  private readonly pipelines = new Map<string, GPUComputePipeline>();
  private readonly layout: GPUBindGroupLayout;

  constructor(
    private readonly device: GPUDevice,
    readonly lane: number,
  ) {
    const storage = (type: GPUBufferBindingType) => ({ type });
    const types: GPUBufferBindingType[] = [
      "uniform",
      "read-only-storage",
      "read-only-storage",
      "read-only-storage",
      "storage",
      "storage",
      "storage",
      "read-only-storage",
    ];
    this.layout = device.createBindGroupLayout({
      label: "every pass",
      entries: types.map((type, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: storage(type) })),
    });
  }

  /** Why the lane's method can't be computed here; `null`: it can. */
  async refusal(): Promise<string | null> {
    this.plan ??= await api.plan(this.lane);
    if (!this.plan.supported) return this.plan.why ?? "the method runs on the server only";
    const bytes = 4 * this.plan.tile_words * this.plan.chunk_tiles;
    const most = this.device.limits.maxStorageBufferBindingSize;
    return bytes > most ? `a chunk needs ${bytes} bytes, the adapter binds ${most}` : null;
  }

  /** Ends after the piece under way. */
  quit(): void {
    this.quitting = true;
  }

  /** Frees all of it. */
  close(): void {
    this.chunks.forEach((b) => b.destroy());
    this.chunks.clear();
  }

  /** Back to no reading at all. */
  async reset(): Promise<void> {
    this.close();
    this.position = 0;
    await api.reset(this.lane);
  }

  /** Brings the map to that reading, from nothing if it is past it, and has every piece compared by the server. */
  async advance(to: number): Promise<Check> {
    if (to < this.position) await this.reset();
    const sum: Check = { tiles: 0, cells: 0, membership: 0, values: 0, largest: 0 };
    let most = PIECE;
    while (this.position < to && !this.quitting) {
      const end = Math.min(to, this.position + most);
      const batch = parse(await api.batch(this.lane, this.position, end));
      if (!this.fits(batch.told) && end - this.position > 1) {
        most = Math.ceil((end - this.position) / 2);
        continue;
      }
      const found = await this.run(batch);
      sum.tiles += found.tiles;
      sum.cells += found.cells;
      sum.membership += found.membership_differences;
      sum.values += found.value_differences;
      sum.largest = Math.max(sum.largest, found.largest ?? 0);
      this.position = end;
    }
    return sum;
  }

  private fits(told: GpuBatch): boolean {
    const spans = [...told.buffers, ...told.chunks.flatMap((c) => [c.tiles, c.entries])];
    const largest = Math.max(told.parts_bytes, ...spans.map((s) => s.bytes));
    return largest <= this.device.limits.maxStorageBufferBindingSize;
  }

  private buffer(label: string, bytes: number, usage: GPUBufferUsageFlags): GPUBuffer {
    return this.device.createBuffer({ label, size: Math.max(SMALLEST, Math.ceil(bytes / 16) * 16), usage });
  }

  private upload(label: string, { file, start }: Batch, { at, bytes }: Span): GPUBindingResource {
    const buffer = this.buffer(
      label,
      bytes,
      GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST | GPUBufferUsage.COPY_SRC,
    );
    if (bytes) this.device.queue.writeBuffer(buffer, 0, file, start + at, Math.ceil(bytes / 4) * 4);
    // A kernel may ask how long an array is: only what is filled is bound.
    return bytes ? { buffer, size: Math.ceil(bytes / 4) * 4 } : { buffer };
  }

  private async pipeline(shader: GpuShader): Promise<GPUComputePipeline> {
    const key = JSON.stringify(shader);
    const known = this.pipelines.get(key);
    if (known) return known;
    const module = this.device.createShaderModule({ label: shader.entry, code: await api.wgsl(shader.path) });
    const made = await this.device.createComputePipelineAsync({
      label: shader.entry,
      layout: this.device.createPipelineLayout({ bindGroupLayouts: [this.layout] }),
      compute: { module, entryPoint: shader.entry, constants: shader.constants },
    });
    this.pipelines.set(key, made);
    return made;
  }

  private cells({ place }: GpuChunk): GPUBuffer {
    const known = this.chunks.get(place.join());
    if (known) return known;
    const { tile_words = 0, chunk_tiles = 0 } = this.plan ?? {};
    const usage = GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC | GPUBufferUsage.COPY_DST;
    const made = this.buffer(`chunk ${place.join()}`, 4 * tile_words * chunk_tiles, usage);
    this.chunks.set(place.join(), made);
    return made;
  }

  /** One batch through every step of the plan. */
  private async run(batch: Batch): Promise<GpuCheck> {
    this.plan ??= await api.plan(this.lane);
    const { device } = this;
    const { told } = batch;
    const made: GPUBuffer[] = [];
    const keep = (resource: GPUBindingResource): GPUBindingResource => {
      if ("buffer" in resource) made.push(resource.buffer);
      return resource;
    };
    const input = (name: string): GPUBindingResource => {
      const span = told.buffers.find((b) => b.name === name) ?? { at: 0, bytes: 0 };
      return keep(this.upload(name, batch, span));
    };
    // The three inputs keep their places in the file, whatever a method calls them.
    const [cones, shares, first] = ["cones", "shares", "first_part"].map((name, k) =>
      input(told.buffers[k]?.name ?? name),
    );
    if (!cones || !shares || !first) throw new Error("the batch lacks its inputs");
    const parts = this.buffer(
      "parts",
      told.parts_bytes,
      GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC | GPUBufferUsage.COPY_DST,
    );
    made.push(parts);
    const chunks = told.chunks.map((chunk) => ({
      chunk,
      tiles: keep(this.upload("tiles", batch, chunk.tiles)),
      entries: keep(this.upload("entries", batch, chunk.entries)),
      cells: this.cells(chunk),
    }));
    try {
      device.pushErrorScope("validation");
      device.pushErrorScope("out-of-memory");
      for (const step of this.plan.steps) {
        if (step.share) {
          await this.share(told, parts, shares);
          continue;
        }
        const shader = told.shaders[step.kernel ?? ""];
        if (!shader) throw new Error(`the batch has no kernel ${step.kernel}`);
        const pipeline = await this.pipeline(shader);
        const frame = this.frame(told, step.mode);
        made.push(frame);
        const encoder = device.createCommandEncoder({ label: shader.entry });
        const summing = step.kernel === "sum";
        for (const { chunk, tiles, entries, cells } of summing ? chunks.slice(0, 1) : chunks) {
          const bound = [{ buffer: frame }, cones, tiles, entries, { buffer: cells }, { buffer: parts }, shares, first];
          const pass = encoder.beginComputePass({ label: shader.entry });
          pass.setPipeline(pipeline);
          pass.setBindGroup(
            0,
            device.createBindGroup({
              label: shader.entry,
              layout: this.layout,
              entries: bound.map((resource, binding) => ({ binding, resource })),
            }),
          );
          pass.dispatchWorkgroups(summing ? Math.ceil(told.readings / SUMMED) : chunk.count);
          pass.end();
        }
        device.queue.submit([encoder.finish()]);
      }
      const words = await this.words(told);
      const failed = (await device.popErrorScope()) ?? (await device.popErrorScope());
      if (failed) throw new Error(`the GPU refuses: ${failed.message}`);
      return await api.words(this.lane, told.to, words);
    } finally {
      made.forEach((b) => b.destroy());
    }
  }

  private frame(told: GpuBatch, mode: number | undefined): GPUBuffer {
    const bytes = decode(told.frame);
    if (mode !== undefined) new DataView(bytes.buffer).setUint32(8, mode, true);
    const buffer = this.buffer("frame", bytes.length, GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST);
    this.device.queue.writeBuffer(buffer, 0, bytes);
    return buffer;
  }

  /** The host makes shares of counts: the one step that is not a kernel's. */
  private async share(told: GpuBatch, parts: GPUBuffer, shares: GPUBindingResource): Promise<void> {
    const counts = await this.read([{ from: parts, at: 0, bytes: 4 * told.readings }]);
    const answer = await api.share(this.lane, told.from, told.to, counts);
    if ("buffer" in shares) this.device.queue.writeBuffer(shares.buffer, 0, answer);
  }

  /** The words of every tile that the batch reached. */
  private words(told: GpuBatch): Promise<Uint8Array<ArrayBuffer>> {
    const bytes = 4 * (this.plan?.tile_words ?? 0);
    return this.read(
      told.chunks.flatMap((chunk) => {
        const from = this.cells(chunk);
        return chunk.slots.map((slot) => ({ from, at: slot * bytes, bytes }));
      }),
    );
  }

  private async read(spans: { from: GPUBuffer; at: number; bytes: number }[]): Promise<Uint8Array<ArrayBuffer>> {
    const total = spans.reduce((sum, s) => sum + s.bytes, 0);
    const out = new Uint8Array(total);
    // Few bytes at a time: a buffer that is mapped has a limit too.
    const most = Math.min(64 << 20, this.device.limits.maxBufferSize);
    for (let k = 0, at = 0; k < spans.length;) {
      const taken: typeof spans = [];
      let bytes = 0;
      for (let s = spans[k]; s && (bytes === 0 || bytes + s.bytes <= most); s = spans[++k]) {
        taken.push(s);
        bytes += s.bytes;
      }
      if (!bytes) continue;
      const staging = this.device.createBuffer({
        label: "read",
        size: bytes,
        usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST,
      });
      const encoder = this.device.createCommandEncoder({ label: "read" });
      let to = 0;
      for (const s of taken) {
        encoder.copyBufferToBuffer(s.from, s.at, staging, to, s.bytes);
        to += s.bytes;
      }
      this.device.queue.submit([encoder.finish()]);
      await staging.mapAsync(GPUMapMode.READ);
      out.set(new Uint8Array(staging.getMappedRange()), at);
      staging.destroy();
      at += bytes;
    }
    return out;
  }
}
