// Tiles: which there are, which changed, what was fetched of them.
//
// A tile keeps its picture until the newer one has come, so that nothing flickers. Few are fetched at once, the latest
// asked for first; what is no longer seen is dropped from the queue.

import { api } from "./api";
import type { CellPoint } from "./generated/protocol";

/** Edge of a tile, pixels. */
export const EDGE = 256;
const AT_ONCE = 6;
const KEPT = 640;

/** A source's number, or the difference of two. */
export type SourceId = number | "difference";

interface Tile {
  /** `null`: nothing there was ever reached; `undefined`: not fetched yet. */
  picture: ImageBitmap | null | undefined;
  stamp: string;
  used: number;
  failed: string | null;
}

interface Wish {
  source: SourceId;
  view: string;
  level: number;
  column: number;
  row: number;
}

const nameOf = (w: Wish): string => `${w.source}/${w.view}/${w.level}/${w.column}/${w.row}`;

/** When each tile of a source changed last: a version, or of those not listed that of all. */
class Versions {
  private all = 0;
  private readonly of = new Map<string, number>();

  mark(changed: CellPoint[] | "all", version: number, levels: number): void {
    if (changed === "all") {
      this.all = version;
      this.of.clear();
      return;
    }
    for (const [column, row] of changed) {
      for (let level = 0, c = column, r = row; level < levels; level++, c >>= 1, r >>= 1) {
        this.of.set(`${level}/${c}/${r}`, version);
      }
    }
  }

  get(level: number, column: number, row: number): number {
    return this.of.get(`${level}/${column}/${row}`) ?? this.all;
  }
}

export class Tiles {
  private readonly tiles = new Map<string, Tile>();
  private readonly versions = new Map<SourceId, Versions>();
  private wishes = new Map<string, Wish>();
  private readonly flying = new Map<string, AbortController>();
  private clock = 0;
  /** Sources whose tiles the browser's own GPU computed. */
  readonly computed = new Set<SourceId>();

  constructor(
    private levels: number,
    private generation: number,
    private readonly arrived: () => void,
  ) {}

  /** Forgets everything: another session. */
  clear(levels: number, generation: number): void {
    this.levels = levels;
    this.generation = generation;
    this.flying.forEach((f) => f.abort());
    this.flying.clear();
    this.wishes.clear();
    this.tiles.forEach((t) => t.picture?.close());
    this.tiles.clear();
    this.versions.clear();
  }

  private versionsOf(source: SourceId): Versions {
    let found = this.versions.get(source);
    if (!found) this.versions.set(source, (found = new Versions()));
    return found;
  }

  /** These tiles of level 0, and what lies above them, are new. */
  changed(source: SourceId, changed: CellPoint[] | "all", version: number): void {
    this.versionsOf(source).mark(changed, version, this.levels);
  }

  private stamp(w: Wish): string {
    const version = this.versionsOf(w.source).get(w.level, w.column, w.row);
    return `${this.generation}.${version}${this.computed.has(w.source) ? "&backend=webgpu" : ""}`;
  }

  /** A tile's picture as far as it is known, and asks for it where it is not the newest. */
  want(source: SourceId, view: string, level: number, column: number, row: number): ImageBitmap | null | undefined {
    const wish = { source, view, level, column, row };
    const name = nameOf(wish);
    const tile = this.tiles.get(name);
    const stamp = this.stamp(wish);
    if (tile) tile.used = ++this.clock;
    if (tile?.stamp !== stamp && tile?.failed !== stamp) this.wishes.set(name, wish);
    return tile?.picture;
  }

  /** A tile's picture if it was fetched, old or new; asks for nothing. */
  peek(source: SourceId, view: string, level: number, column: number, row: number): ImageBitmap | null | undefined {
    return this.tiles.get(nameOf({ source, view, level, column, row }))?.picture;
  }

  /** A drawing begins: only what it wants counts from now on. */
  begin(): void {
    this.wishes = new Map();
  }

  /** It ended: fetches what is missing, and stops what nobody wants any more. */
  end(): void {
    for (const [name, fetch] of this.flying) {
      if (!this.wishes.has(name)) fetch.abort();
    }
    this.pump();
  }

  /** Whether tiles of a source are still to come. */
  lacks(source: SourceId): boolean {
    return [...this.wishes.values()].some((w) => w.source === source);
  }

  /** How many tiles are still to come. */
  get missing(): number {
    return this.wishes.size + this.flying.size;
  }

  private pump(): void {
    for (const [name, wish] of this.wishes) {
      if (this.flying.size >= AT_ONCE) return;
      if (!this.flying.has(name)) void this.fetch(name, wish);
    }
  }

  private async fetch(name: string, wish: Wish): Promise<void> {
    const abort = new AbortController();
    this.flying.set(name, abort);
    const stamp = this.stamp(wish);
    const { source, view, level, column, row } = wish;
    const path = `api/tile?source=${source}&view=${encodeURIComponent(view)}&level=${level}&column=${column}&row=${row}&v=${stamp}`;
    try {
      const picture = await api.tile(path, abort.signal);
      if (this.flying.get(name) !== abort) {
        picture?.close();
        return;
      }
      this.put(name, { picture, stamp, used: ++this.clock, failed: null });
    } catch (e) {
      if (this.flying.get(name) !== abort) return;
      if (!abort.signal.aborted) this.fail(name, stamp);
      if (!abort.signal.aborted) console.warn(`tile ${name}:`, e);
    } finally {
      if (this.flying.get(name) === abort) {
        this.flying.delete(name);
        if (this.stamp(wish) === stamp && !abort.signal.aborted) this.wishes.delete(name);
        this.arrived();
        this.pump();
      }
    }
  }

  /** Keeps what was there, and asks no more until the tile changes. */
  private fail(name: string, stamp: string): void {
    const old = this.tiles.get(name);
    this.tiles.set(name, { picture: old?.picture, stamp: old?.stamp ?? "", used: ++this.clock, failed: stamp });
  }

  private put(name: string, tile: Tile): void {
    this.tiles.get(name)?.picture?.close();
    this.tiles.set(name, tile);
    if (this.tiles.size <= KEPT) return;
    const oldest = [...this.tiles].sort((a, b) => a[1].used - b[1].used).slice(0, KEPT / 8);
    for (const [old, { picture }] of oldest) {
      picture?.close();
      this.tiles.delete(old);
    }
  }
}
