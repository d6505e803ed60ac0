// The state of the page in its address, ?scene=&t=&cam=&view=&rate=&paused=&loop=&path=&ui=, so
// that a copied address shows the same time from the same camera.

export interface UrlState {
  scene: string | null;
  seconds: number | null; // from the start of the clip
  camera: string | null; // name, or number from 1
  view: string | null; // as in shared_view.ts; goes before the camera
  rate: number | null;
  paused: boolean;
  loop: boolean;
  path: boolean; // whether the camera moves by itself
  panels: boolean;
}

function numberOf(value: string | null): number | null {
  const number = value === null || value.trim() === "" ? NaN : Number(value);
  return Number.isFinite(number) ? number : null;
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
    path: flagOf(query.get("path"), false),
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
