// What page and server say to each other of the browser's own GPU; README.md is the text of it.

export interface GpuStep {
  kernel?: string;
  mode?: number;
  share?: boolean;
}

export interface GpuPlan {
  supported: boolean;
  why: string | null;
  tile_words: number;
  chunk_tiles: number;
  steps: GpuStep[];
}

export interface Span {
  at: number;
  bytes: number;
}

export interface GpuShader {
  path: string;
  entry: string;
  constants: Record<string, number>;
}

export interface GpuChunk {
  place: [number, number];
  tiles: Span;
  entries: Span;
  count: number;
  slots: number[];
}

export interface GpuBatch {
  from: number;
  to: number;
  frame: Span;
  readings: number;
  parts_bytes: number;
  shaders: Record<string, GpuShader>;
  buffers: (Span & { name: string })[];
  chunks: GpuChunk[];
}

export interface GpuCheck {
  tiles: number;
  cells: number;
  membership_differences: number;
  value_differences: number;
  largest: number | null;
}
