// The browser's GPU, if it has one.

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

/** What every pass binds: frame, cones, tiles, entries, cells, parts, shares, first part. */
export function bindings(device: GPUDevice): GPUBindGroupLayout {
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
  return device.createBindGroupLayout({
    label: "every pass",
    entries: types.map((type, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: storage(type) })),
  });
}
