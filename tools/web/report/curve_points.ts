// Curves as columns over one ascending x, for charts and for CSV files.
import type { Curve } from "./data";

export type XName = "step" | "seconds";

export interface Line {
  label: string;
  colour: string;
  dashed: boolean;
  name: string; // in the legend, where lines of one name share an entry
  curve: Curve;
}

type Columns = [number[], ...(number | null)[][]];

/** Value by x; points whose x is unknown are left out. */
function points(curve: Curve, x: XName): Map<number, number> {
  const made = new Map<number, number>();
  curve.step.forEach((step, i) => {
    const place = x === "step" ? step : curve.seconds[i];
    const value = curve.value[i];
    if (typeof place === "number" && typeof value === "number") made.set(place, value);
  });
  return made;
}

/** First and last x of all lines, or null where no line has a point. */
export function extent(lines: Line[], x: XName): [number, number] | null {
  const all = lines.flatMap((line) => [...points(line.curve, x).keys()]);
  if (all.length === 0) return null;
  return all.reduce(([low, high], at) => [Math.min(low, at), Math.max(high, at)], [all[0], all[0]]);
}

/** null where a line has no point at an x, of `ends` as well. `positive`: for logarithmic axes. */
export function columns(lines: Line[], x: XName, ends: number[] = [], positive = false): Columns {
  const all = lines.map((line) => points(line.curve, x));
  const xs = [...new Set([...ends, ...all.flatMap((line) => [...line.keys()])])];
  xs.sort((a, b) => a - b);
  const value = (line: Map<number, number>, at: number) => {
    const found = line.get(at) ?? null;
    return found !== null && positive && found <= 0 ? null : found;
  };
  return [xs, ...all.map((line) => xs.map((at) => value(line, at)))];
}

export function csv(lines: Line[], x: XName): string {
  const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
  const [xs, ...values] = columns(lines, x);
  const rows = xs.map((at, i) => [at, ...values.map((column) => column[i] ?? "")].join(","));
  return [[x, ...lines.map((line) => quoted(line.label))].join(","), ...rows, ""].join("\n");
}
