// Bounds and ticks of logarithmic axes: 1, 2 and 5 of each power of ten; over many powers, these
// alone.
const MANY_DECADES = 3;

/** The ticks from the last below `low` to the first above `high`; both are positive. */
export function logarithmicTicks(low: number, high: number): number[] {
  const digits = Math.log10(high / low) > MANY_DECADES ? [1] : [1, 2, 5];
  const all: number[] = [];
  const last = Math.ceil(Math.log10(high)) + 1;
  for (let decade = Math.floor(Math.log10(low)) - 1; decade <= last; ++decade)
    for (const digit of digits) all.push(Number(`${digit}e${decade}`));
  let begin = 0;
  let end = all.length - 1;
  while (all[begin + 1] <= low * (1 + 1e-9)) ++begin;
  while (all[end - 1] >= high * (1 - 1e-9)) --end;
  if (begin === end) {
    --begin;
    ++end;
  }
  return all.slice(begin, end + 1);
}

/** Bounds for values from `low` to `high`, null where there are none. */
export function logarithmicRange(low: number | null, high: number | null): [number, number] {
  if (low === null || high === null || !(low > 0)) return [1, 10];
  const ticks = logarithmicTicks(low, high);
  return [ticks[0], ticks[ticks.length - 1]];
}

/** Four to nine round ticks, the first not above `low` and the last not below `high`. */
export function linearTicks(low: number, high: number): number[] {
  const span = high > low ? high - low : Math.abs(low) * 0.1 || 1;
  const raw = span / 4;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((digit) => digit * power).find((size) => size >= raw)!;
  const first = Math.floor(low / step + 1e-9);
  const last = Math.max(first + 1, Math.ceil(high / step - 1e-9));
  return Array.from({ length: last - first + 1 }, (_, i) =>
    Number(((first + i) * step).toPrecision(12)));
}
