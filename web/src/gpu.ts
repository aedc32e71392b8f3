// A lane's map, computed by the browser's own GPU with the project's own kernels: no more than buffers and dispatches,
// in the order that the server's plan gives. No part of the page is known here.

import { api } from "./api";
import { type Check, add, none } from "./gpu-check";
import { bindings } from "./gpu-device";
import { type Batch, type Piece, parse, posts, read } from "./gpu-bytes";
import type { GpuBatch, GpuChunk, GpuPlan, GpuShader, GpuSpan } from "./generated/protocol";

/** Readings in a batch, at most. */
const PIECE = 4096;
/** Bytes of the smallest buffer: a kernel's arrays want an element at least. */
const SMALLEST = 256;
/** Threads of a group that sums. */
const SUMMED = 64;

/** One lane. */
export class Runner {
  /** The readings that its map holds. */
  position = 0;
  private plan: GpuPlan | null = null;
  private quitting = false;
  private readonly chunks = new Map<string, GPUBuffer>();
  /** Tiles that were reached since the server saw them last: a chunk's place and slot. */
  private readonly reached = new Map<string, [number, number, number]>();
  private readonly pipelines = new Map<string, GPUComputePipeline>();
  private readonly layout: GPUBindGroupLayout;

  constructor(
    private readonly device: GPUDevice,
    readonly lane: number,
  ) {
    this.layout = bindings(device);
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
    this.reached.clear();
  }

  /** Back to no reading at all. */
  async reset(): Promise<void> {
    this.close();
    this.position = 0;
    await api.reset(this.lane);
  }

  /**
   * Brings the map to that reading, from nothing if it is past it. The server stands there already: it compares all that
   * was reached on the way.
   */
  async advance(to: number): Promise<Check> {
    if (to < this.position) await this.reset();
    let most = PIECE;
    while (this.position < to && !this.quitting) {
      const end = Math.min(to, this.position + most);
      const batch = parse(await api.batch(this.lane, this.position, end));
      if (!this.fits(batch.header) && end - this.position > 1) {
        most = Math.ceil((end - this.position) / 2);
        continue;
      }
      await this.run(batch);
      this.position = end;
    }
    return this.compare();
  }

  /** Shows the server every tile that it has not seen as it is now. */
  private async compare(): Promise<Check> {
    let sum = none();
    const bytes = 4 * (this.plan?.tile_words ?? 0);
    const all = posts([...this.reached.values()], bytes);
    // Even with nothing to show: the server compares what it reached and the page did not.
    for (const [k, tiles] of (all.length ? all : [[]]).entries()) {
      if (this.quitting) break;
      const pieces = tiles.map(([column, row, slot]): Piece => {
        const from = this.chunks.get([column, row].join());
        if (!from) throw new Error(`no chunk ${column}, ${row}`);
        return { from, at: slot * bytes, bytes };
      });
      const head = new Uint32Array([tiles.length, ...tiles.flat()]);
      const found = await api.words(
        this.lane,
        this.position,
        await read(this.device, pieces, new Uint8Array(head.buffer)),
        k + 1 < all.length,
      );
      tiles.forEach((tile) => this.reached.delete(tile.join()));
      sum = add(sum, {
        tiles: found.tiles,
        cells: found.cells,
        membership: found.membership_differences,
        values: found.value_differences,
        largest: found.largest ?? 0,
      });
    }
    return sum;
  }

  private fits(header: GpuBatch): boolean {
    const spans = [...header.buffers, ...header.chunks.flatMap((c) => [c.tiles, c.entries])];
    const largest = Math.max(header.parts_bytes, ...spans.map((s) => s.bytes));
    return largest <= this.device.limits.maxStorageBufferBindingSize;
  }

  private buffer(label: string, bytes: number, usage: GPUBufferUsageFlags): GPUBuffer {
    return this.device.createBuffer({ label, size: Math.max(SMALLEST, Math.ceil(bytes / 16) * 16), usage });
  }

  private upload(label: string, { file, start }: Batch, { at, bytes }: GpuSpan): GPUBindingResource {
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
  private async run(batch: Batch): Promise<void> {
    this.plan ??= await api.plan(this.lane);
    const { device } = this;
    const { header } = batch;
    const made: GPUBuffer[] = [];
    const keep = (resource: GPUBindingResource): GPUBindingResource => {
      if ("buffer" in resource) made.push(resource.buffer);
      return resource;
    };
    const input = (name: string): GPUBindingResource => {
      const span = header.buffers.find((b) => b.name === name) ?? { at: 0, bytes: 0 };
      return keep(this.upload(name, batch, span));
    };
    // The three inputs keep their places in the file, whatever a method calls them.
    const [cones, shares, first] = ["cones", "shares", "first_part"].map((name, k) =>
      input(header.buffers[k]?.name ?? name),
    );
    if (!cones || !shares || !first) throw new Error("the batch lacks its inputs");
    const parts = this.buffer(
      "parts",
      header.parts_bytes,
      GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC | GPUBufferUsage.COPY_DST,
    );
    made.push(parts);
    const chunks = header.chunks.map((chunk) => ({
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
          await this.share(header, parts, shares);
          continue;
        }
        const shader = header.shaders[step.kernel ?? ""];
        if (!shader) throw new Error(`the batch has no kernel ${step.kernel}`);
        const pipeline = await this.pipeline(shader);
        const frame = this.frame(batch, step.mode);
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
          pass.dispatchWorkgroups(summing ? Math.ceil(header.readings / SUMMED) : chunk.count);
          pass.end();
        }
        device.queue.submit([encoder.finish()]);
      }
      const failed = await Promise.all([device.popErrorScope(), device.popErrorScope()]);
      const error = failed.find((e) => e);
      if (error) throw new Error(`the GPU refuses: ${error.message}`);
      for (const { place, slots } of header.chunks) {
        for (const slot of slots) this.reached.set([...place, slot].join(), [...place, slot]);
      }
    } finally {
      made.forEach((b) => b.destroy());
    }
  }

  private frame({ header, file, start }: Batch, mode: number | undefined): GPUBuffer {
    const { at, bytes } = header.frame;
    const words = file.slice(start + at, start + at + bytes);
    if (mode !== undefined) new DataView(words).setUint32(8, mode, true);
    const buffer = this.buffer("frame", bytes, GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST);
    this.device.queue.writeBuffer(buffer, 0, words);
    return buffer;
  }

  /** The host makes shares of counts: the one step that is not a kernel's. */
  private async share(header: GpuBatch, parts: GPUBuffer, shares: GPUBindingResource): Promise<void> {
    const counts = await read(this.device, [{ from: parts, at: 0, bytes: 4 * header.readings }]);
    const answer = await api.share(this.lane, header.from, header.to, counts);
    if ("buffer" in shares) this.device.queue.writeBuffer(shares.buffer, 0, answer);
  }
}
