// The windows of a long clip: each was trained on its own range of time, which overlaps its
// neighbours', and is drawn in its core alone; the cores tile the clip. Gaussians of a window are in
// its own time tau. Source: docs/reference/tessera4d.md.
import type { Fields } from "./json_fields";
import type { Triple } from "./manifest";

export const WINDOWS_VERSION = 3; // of files that have windows

export interface Window {
  time: [number, number]; // t of the clip where tau is 0 and 1
  drawn: [number, number]; // t of the clip: the core, without its end
  light: Triple; // factors of the colours of static Gaussians while it is drawn
}

function readSpan(f: Fields, name: string): [number, number] {
  const [from, to] = f.numbers(name, 2);
  if (!(from < to)) throw f.wrong(name, "a time and a later one", [from, to]);
  return [from, to];
}

function readOne(f: Fields): Window {
  const time = readSpan(f, "time");
  const drawn = readSpan(f, "drawn");
  if (drawn[0] < time[0] || drawn[1] > time[1])
    throw f.wrong("drawn", `within time (${time.join(" to ")})`, drawn);
  const light: Triple = f.has("light") ? f.triple("light") : [1, 1, 1];
  if (!light.every((factor) => factor > 0 && factor < 100))
    throw f.wrong("light", "3 numbers between 0 and 100", light);
  return { time, drawn, light };
}

/** Of a file of version 3. Throws PlayerError unless their cores tile 0 to 1. */
export function readWindows(f: Fields): Window[] {
  const windows = f.list("windows", readOne);
  if (windows.length === 0) throw f.wrong("windows", "a list of at least one", f.raw("windows"));
  windows.forEach(({ drawn }, i) => {
    const begin = i === 0 ? 0 : windows[i - 1].drawn[1];
    if (drawn[0] !== begin)
      throw f.wrong(`windows[${i}].drawn`, `a core that begins at ${begin}`, drawn);
  });
  const last = windows[windows.length - 1].drawn;
  if (last[1] !== 1)
    throw f.wrong(`windows[${windows.length - 1}].drawn`, "a core that ends at 1", last);
  return windows;
}

/** From which t on and before which t window i is drawn; the last one is drawn at t = 1, too. */
export function drawnSpan(windows: readonly Window[], i: number): [number, number] {
  const [from, to] = windows[i].drawn;
  return [from, i + 1 === windows.length ? Infinity : to];
}

/** Of static Gaussians at t of the clip. */
export function lightAt(windows: readonly Window[], t: number): Triple {
  return windows.filter(({ drawn }, i) => i === 0 || drawn[0] <= t).at(-1)?.light ?? [1, 1, 1];
}

/** The time of the Gaussians of a block at t of the clip: tau of its window, or t itself. */
export function ownTime(windows: readonly Window[], window: number | null, t: number): number {
  if (window === null) return t;
  const [from, to] = windows[window].time;
  return (t - from) / (to - from);
}
