// What: the manifest of a Tessera 4D file, read and checked: whatever passes can be decoded without
//       looking at its numbers again.
// Not: the blocks (tessera4d.ts), nor where bytes come from (container.ts).
// Source: docs/reference/tessera4d.md.
import { PlayerError } from "./player_error";

export const FORMAT = "tessera-4d";
export const VERSION = 1;

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

export interface Stream {
  name: string;
  type: string;
  components: number;
  count: number; // of the first Gaussians of the block
  scale: number[]; // per component; empty for f32
  bias: number[];
  delta: boolean;
  codec: string;
  offset: number; // within the block, bytes
  bytes: number;
}

export interface Block {
  name: string; // for messages: its file, or its place in the single file
  kind: "static" | "dynamic";
  file: string | null; // of a folder
  offset: number; // in a single file: from the end of the manifest, bytes
  bytes: number;
  crc32: number;
  visible: [number, number]; // t
  count: number;
  streams: Stream[];
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
  gaussians: { static: number; dynamic: number };
  background: Triple; // sRGB, 0 to 255
  splat: SplatRules;
  anchor: "clip" | "mean_time";
  cameras: Camera[];
  audio: string | null;
  blocks: Block[];
}

const MAX_COUNT = 2 ** 27; // Gaussians of a block: more do not fit any card
const MAX_BYTES = 2 ** 31;

/** Reads fields of one JSON object; every complaint names the file and the key. */
class Fields {
  private readonly object: Record<string, unknown>;
  constructor(
    value: unknown,
    private readonly file: string,
    private readonly path: string,
  ) {
    if (typeof value !== "object" || value === null || Array.isArray(value))
      throw this.wrong(path || "the manifest", "an object", value);
    this.object = value as Record<string, unknown>;
  }
  wrong(key: string, expected: string, seen: unknown): PlayerError {
    const text = JSON.stringify(seen) ?? "nothing";
    return new PlayerError(
      `${this.file}: ${key} should be ${expected}, saw ${text.slice(0, 40)}; ` +
        `export the scene again`,
    );
  }
  private key(name: string): string {
    return this.path ? `${this.path}.${name}` : name;
  }
  has(name: string): boolean {
    return this.object[name] !== undefined && this.object[name] !== null;
  }
  raw(name: string): unknown {
    return this.object[name];
  }
  number(name: string, fallback?: number): number {
    const value = this.object[name];
    if (value === undefined && fallback !== undefined) return fallback;
    if (typeof value !== "number" || !Number.isFinite(value))
      throw this.wrong(this.key(name), "a number", value);
    return value;
  }
  /** An integer from 0 to `limit`. */
  size(name: string, limit: number): number {
    const value = this.object[name];
    if (typeof value !== "number" || !Number.isSafeInteger(value) || value < 0 || value > limit)
      throw this.wrong(this.key(name), `an integer from 0 to ${limit}`, value);
    return value;
  }
  text(name: string): string {
    const value = this.object[name];
    if (typeof value !== "string") throw this.wrong(this.key(name), "a string", value);
    return value;
  }
  flag(name: string, fallback: boolean): boolean {
    const value = this.object[name] ?? fallback;
    if (typeof value !== "boolean") throw this.wrong(this.key(name), "true or false", value);
    return value;
  }
  numbers(name: string, count: number): number[] {
    const value = this.object[name];
    if (!Array.isArray(value) || value.length !== count || !value.every(Number.isFinite))
      throw this.wrong(this.key(name), `${count} numbers`, value);
    return value as number[];
  }
  triple(name: string): Triple {
    return this.numbers(name, 3) as Triple;
  }
  within(name: string): Fields {
    return new Fields(this.object[name], this.file, this.key(name));
  }
  list<T>(name: string, make: (item: Fields, i: number) => T): T[] {
    const value = this.object[name] ?? [];
    if (!Array.isArray(value)) throw this.wrong(this.key(name), "a list", value);
    return value.map((item, i) => make(new Fields(item, this.file, `${this.key(name)}[${i}]`), i));
  }
}

function readCamera(f: Fields): Camera {
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

function readStream(f: Fields, blockBytes: number, blockCount: number): Stream {
  const type = f.text("type");
  const components = f.size("components", 64);
  const scaled = /^u\d+$/.test(type);
  const stream: Stream = {
    name: f.text("name"),
    type,
    components,
    count: f.size("count", blockCount),
    scale: scaled ? f.numbers("scale", components) : [],
    bias: scaled ? f.numbers("bias", components) : [],
    delta: f.flag("delta", false),
    codec: f.text("codec"),
    offset: f.size("offset", blockBytes),
    bytes: f.size("bytes", blockBytes),
  };
  if (stream.offset + stream.bytes > blockBytes)
    throw f.wrong("offset + bytes", `at most ${blockBytes}`, stream.offset + stream.bytes);
  return stream;
}

/** `file` of a block: below the manifest, so that no page is led to another server. */
function localFile(f: Fields): string | null {
  if (!f.has("file")) return null;
  const file = f.text("file");
  if (file === "" || /^[/\\]|[:\\]|(^|\/)\.\.(\/|$)/.test(file))
    throw f.wrong("file", "a file below the manifest", file);
  return file;
}

function readBlock(f: Fields, i: number): Block {
  const kind = f.text("kind");
  if (kind !== "static" && kind !== "dynamic") throw f.wrong("kind", "static or dynamic", kind);
  const bytes = f.size("bytes", MAX_BYTES);
  const count = f.size("count", MAX_COUNT);
  const file = localFile(f);
  const visible = f.numbers("visible", 2) as [number, number];
  return {
    name: file ?? `block ${i}`,
    kind,
    file,
    offset: file === null ? f.size("offset", Number.MAX_SAFE_INTEGER) : 0,
    bytes,
    crc32: f.size("crc32", 0xffffffff),
    visible,
    count,
    streams: f.list("streams", (stream) => readStream(stream, bytes, count)),
  };
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
  return {
    name: file,
    up: f.triple("up"),
    time: {
      origin: time.number("origin", 0),
      duration: Math.max(0, time.number("duration", 0)),
      fps: time.has("fps") ? time.number("fps") : null,
    },
    bounds: readBounds(f.raw("bounds"), file),
    gaussians: { static: counts.size("static", 2 ** 40), dynamic: counts.size("dynamic", 2 ** 40) },
    background: f.triple("background"),
    splat: readSplat(f.within("splat")),
    anchor,
    cameras: f.list("cameras", readCamera),
    audio: f.has("audio") ? f.text("audio") : null,
    blocks: f.list("blocks", readBlock),
  };
}
