// The state of the page in its address, ?scene=&t=&cam=&view=&rate=&paused=&loop=&part=&path=&bg=&ui=,
// so that a copied address shows the same time from the same camera.
import type { Part } from "./clock";
import type { Triple } from "./manifest";

export interface UrlState {
  scene: string | null;
  seconds: number | null; // from the start of the clip
  camera: string | null; // name, or number from 1
  view: string | null; // as in shared_view.ts; goes before the camera
  rate: number | null;
  paused: boolean;
  loop: boolean;
  part: Part | null; // that is played over and over
  path: boolean; // whether the camera moves by itself
  background: Triple | null; // in the place of the scene's
  panels: boolean;
}

function numberOf(value: string | null): number | null {
  const number = value === null || value.trim() === "" ? NaN : Number(value);
  return Number.isFinite(number) ? number : null;
}

/** "0.5-1.25", seconds. */
export function partOf(value: string | null): Part | null {
  const [, from, to] = /^(\d*\.?\d+)-(\d*\.?\d+)$/.exec(value ?? "") ?? [];
  return from !== undefined && Number(to) > Number(from)
    ? { from: Number(from), to: Number(to) }
    : null;
}

/** "ffffff", or null. */
export function colourOf(value: string | null): Triple | null {
  if (!/^[0-9a-f]{6}$/i.test(value ?? "")) return null;
  return [0, 2, 4].map((k) => parseInt(value!.slice(k, k + 2), 16)) as Triple;
}

/** A bare key (?paused) means yes. */
function flagOf(value: string | null, absent: boolean): boolean {
  return value === null ? absent : !["0", "false", "no", "off"].includes(value.toLowerCase());
}

/** `search`: as location.search. Values that mean nothing are as if they were absent. */
export function readUrl(search: string): UrlState {
  const query = new URLSearchParams(search);
  const rate = numberOf(query.get("rate"));
  return {
    scene: query.get("scene"),
    seconds: numberOf(query.get("t")),
    camera: query.get("cam"),
    view: query.get("view"),
    rate: rate !== null && rate > 0 ? rate : null,
    paused: flagOf(query.get("paused"), false),
    loop: flagOf(query.get("loop"), true),
    part: partOf(query.get("part")),
    path: flagOf(query.get("path"), false),
    background: colourOf(query.get("bg")),
    panels: flagOf(query.get("ui"), true),
  };
}

/** The address with these values in place; null takes a key away. */
export function withValues(href: string, values: Record<string, string | null>): string {
  const url = new URL(href);
  for (const [key, value] of Object.entries(values))
    if (value === null) url.searchParams.delete(key);
    else url.searchParams.set(key, value);
  return url.href;
}

/** Puts values into the address bar, where the browser lets a page do so. */
export function rememberInUrl(values: Record<string, string | null>): void {
  try {
    history.replaceState(null, "", withValues(location.href, values));
  } catch {
    // a page from a disk or in a sandboxed frame: the address stays as it is
  }
}
