// What a key may be set to, read from the server's own words for it: a choice, a range, a length.

import type { ParameterInfo } from "./generated/protocol";

export interface Range {
  low: number;
  high: number;
  /** Equal steps of the slider are equal factors. */
  factors: boolean;
  unit: string;
}

const NUMBER = String.raw`-?\d+(?:\.\d+)?(?:e-?\d+)?`;
const SPAN = new RegExp(`(${NUMBER})\\.\\.(${NUMBER})\\s*(deg|rad|m)?`);

/** The words of a choice; `null` where other values are allowed too. */
export function choices(key: ParameterInfo): string[] | null {
  const words = key.values.split("|").map((w) => w.trim());
  const plain = (w: string) => /^[\w/.-]+$/.test(w) && !w.includes("..") && !/^(number|length|N)$/.test(w);
  return words.length > 1 && words.every(plain) ? words : null;
}

/** Words that stand beside a range: `1/n`, `all`. */
export function words(key: ParameterInfo): string[] {
  return key.values
    .split("|")
    .map((w) => w.trim())
    .filter((w) => /^[\w/-]+$/.test(w) && !/^(number|length|N)$/.test(w));
}

/** The reach of a slider; a length that has no upper end gets a tenth to ten times of what it is now. */
export function range(key: ParameterInfo, now: string): Range | null {
  const span = SPAN.exec(key.values);
  if (span) {
    const [low, high] = [Number(span[1]), Number(span[2])];
    return { low, high, factors: low > 0 && high / low > 50, unit: span[3] === "deg" ? "deg" : "" };
  }
  const value = plain(now);
  if (!/length/.test(key.values) || value === null || value <= 0) return null;
  return { low: value / 10, high: value * 10, factors: true, unit: "" };
}

/** A value in metres or radians, whatever unit it was written in. */
export function plain(text: string): number | null {
  const found = new RegExp(`^\\s*(${NUMBER})\\s*(deg|rad|mm|cm|m)?\\s*$`).exec(text);
  if (!found) return null;
  const factor: Record<string, number> = { deg: Math.PI / 180, mm: 0.001, cm: 0.01 };
  return Number(found[1]) * (factor[found[2] ?? ""] ?? 1);
}

/** Where a slider of 0 to 1000 stands for a text. */
export function toSlider(r: Range, text: string): number {
  const value = plain(text);
  if (value === null) return 0;
  const own = r.unit === "deg" ? (value * 180) / Math.PI : value;
  const part = r.factors ? Math.log(own / r.low) / Math.log(r.high / r.low) : (own - r.low) / (r.high - r.low);
  return Math.round(1000 * Math.min(1, Math.max(0, part)));
}

/** The text for a place of the slider. */
export function fromSlider(r: Range, place: number): string {
  const part = place / 1000;
  const value = r.factors ? r.low * (r.high / r.low) ** part : r.low + (r.high - r.low) * part;
  return `${Number(value.toPrecision(3))}${r.unit}`;
}

/** A value as it fits into a field: four digits, angles in degrees. */
export function brief(key: ParameterInfo, text: string): string {
  const value = plain(text);
  if (value === null) return text;
  if (!/deg/.test(key.values)) return String(Number(value.toPrecision(4)));
  return `${Number(((value * 180) / Math.PI).toPrecision(4))}deg`;
}
