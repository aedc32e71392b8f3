// WebGPU's constants, which TypeScript's own library leaves out.

declare const GPUBufferUsage: Readonly<{
  MAP_READ: number;
  COPY_SRC: number;
  COPY_DST: number;
  UNIFORM: number;
  STORAGE: number;
}>;
declare const GPUMapMode: Readonly<{ READ: number }>;
declare const GPUShaderStage: Readonly<{ COMPUTE: number }>;
