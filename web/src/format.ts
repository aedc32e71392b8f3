// Numbers as people read them.

/** About four digits; a dash for what is not finite. */
export function number(value: number | string | null | undefined): string {
  if (typeof value === "string") return value;
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (Number.isInteger(value)) return String(value);
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(3);
  return String(Number(value.toPrecision(4)));
}

/** Metres, to the millimetre. */
export function metres(value: number | null | undefined): string {
  return value === null || value === undefined ? "–" : `${value.toFixed(3)} m`;
}

/** A time of the log, to the hundredth of a second, as the status line has it. */
export function seconds(value: number | null | undefined): string {
  return value === null || value === undefined ? "–" : `${value.toFixed(2)} s`;
}

/** Degrees from −180 to 180, from radians. */
export function degrees(value: number | null | undefined): string {
  if (value === null || value === undefined) return "–";
  const turned = (value * 180) / Math.PI;
  return `${(turned - 360 * Math.round(turned / 360)).toFixed(1)}°`;
}

/** A count, its thousands apart. */
export function count(value: number): string {
  return value.toLocaleString("en-GB");
}

/** A change of some layers: `p 0.5 → 0.4`. */
export function change(layers: string[], before: (number | null)[], after: (number | null)[]): string {
  return layers.map((layer, k) => `${layer} ${number(before[k])} → ${number(after[k])}`).join(", ");
}
