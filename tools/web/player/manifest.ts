// Reads and checks the manifest of a Tessera 4D file: a manifest that passes can be decoded without
// further checks of its numbers. Source: docs/reference/tessera4d.md.
import { Fields } from "./json_fields";
import { readBlocks, type Block } from "./manifest_blocks";
import { PlayerError } from "./player_error";
import { readWindows, WINDOWS_VERSION, type Window } from "./windows";

export const FORMAT = "tessera-4d";
export const VERSION = 3;

export type Triple = [number, number, number];
/** w, x, y, z */
export type Quaternion = [number, number, number, number];

export interface Camera {
  name: string;
  position: Triple; // world units
  rotation: Quaternion; // x_world = R x_camera + position; camera: right, down, forward
  width: number; // pixels, as the four below
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

export interface SplatRules {
  dilation: number; // pixels²
  compensated: boolean;
  cutoffSigma: number;
  cutoffAlpha: number;
  near: number | null; // world units; nothing nearer is drawn
}

export interface Bounds {
  min: Triple;
  max: Triple;
}

export interface Manifest {
  name: string; // of the file it was read from
  up: Triple;
  time: { origin: number; duration: number; fps: number | null }; // seconds
  bounds: Bounds | null;
  gaussians: { static: number; dynamic: number; canonical: number };
  /** The most Gaussians that any time needs, where a file says it. */
  peak: number | null;
  background: Triple; // sRGB, 0 to 255
  splat: SplatRules;
  anchor: "clip" | "mean_time";
  cameras: Camera[];
  audio: string | null;
  windows: Window[]; // none before version 3
  blocks: Block[];
}

export function readCamera(f: Fields): Camera {
  const rotation = f.numbers("rotation", 4) as Quaternion;
  const camera = {
    name: f.text("name"),
    position: f.triple("position"),
    rotation,
    width: f.number("width"),
    height: f.number("height"),
    fx: f.number("fx"),
    fy: f.number("fy"),
    cx: f.number("cx"),
    cy: f.number("cy"),
  };
  if (!(Math.hypot(...rotation) > 0)) throw f.wrong("rotation", "a quaternion", rotation);
  for (const key of ["width", "height", "fx", "fy"] as const)
    if (!(camera[key] > 0)) throw f.wrong(key, "above 0", camera[key]);
  return camera;
}

function readSplat(f: Fields): SplatRules {
  return {
    dilation: f.number("dilation"),
    compensated: f.flag("compensated", false),
    cutoffSigma: f.number("cutoff_sigma"),
    cutoffAlpha: f.number("cutoff_alpha"),
    near: f.has("near") ? f.number("near") : null,
  };
}

/** The fields that sequences have as well: see sequence.ts. */
export function readBounds(value: unknown, file: string): Bounds | null {
  if (value === null || value === undefined) return null;
  const f = new Fields(value, file, "bounds");
  return { min: f.triple("min"), max: f.triple("max") };
}

export function readCameras(manifest: unknown, file: string): Camera[] {
  return new Fields(manifest, file, "").list("cameras", readCamera);
}

/** JSON text of any manifest that the player knows. */
export function parseJson(text: string, file: string): Record<string, unknown> {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    throw new PlayerError(`${file}: no JSON, so no manifest; point scene at an exported manifest`);
  }
  new Fields(value, file, "");
  return value as Record<string, unknown>;
}

/**
 * Checks a manifest of format tessera-4d. `file` is named in messages.
 * Throws PlayerError for another format, a later version and any value out of bounds.
 */
export function readManifest(json: unknown, file: string): Manifest {
  const f = new Fields(json, file, "");
  if (f.raw("format") !== FORMAT) throw f.wrong("format", `"${FORMAT}"`, f.raw("format"));
  const version = f.size("version", Number.MAX_SAFE_INTEGER);
  if (version > VERSION)
    throw new PlayerError(
      `${file}: version ${version} is later than this player knows (${VERSION}); ` +
        `take the index.html of the export that wrote it`,
    );
  const time = f.within("time");
  const anchor = f.text("anchor");
  if (anchor !== "clip" && anchor !== "mean_time")
    throw f.wrong("anchor", `"clip" or "mean_time"`, anchor);
  const counts = f.within("gaussians");
  const windows = version >= WINDOWS_VERSION ? readWindows(f) : [];
  return {
    name: file,
    up: f.triple("up"),
    time: {
      origin: time.number("origin", 0),
      duration: Math.max(0, time.number("duration", 0)),
      fps: time.has("fps") ? time.number("fps") : null,
    },
    bounds: readBounds(f.raw("bounds"), file),
    gaussians: {
      static: counts.size("static", 2 ** 40),
      dynamic: counts.size("dynamic", 2 ** 40),
      canonical: counts.has("canonical") ? counts.size("canonical", 2 ** 40) : 0,
    },
    peak: windows.length > 0 ? counts.size("peak", 2 ** 40) : null,
    background: f.triple("background"),
    splat: readSplat(f.within("splat")),
    anchor,
    cameras: f.list("cameras", readCamera),
    audio: f.has("audio") ? f.text("audio") : null,
    windows,
    blocks: readBlocks(f, version, windows),
  };
}
