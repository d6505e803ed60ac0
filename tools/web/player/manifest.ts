// Reads and checks the manifest of a Tessera 4D file: a manifest that passes can be decoded without
// further checks of its numbers. Source: docs/reference/tessera4d.md.
import { Fields } from "./json_fields";
import { PlayerError } from "./player_error";

export const FORMAT = "tessera-4d";
export const VERSION = 2;
const NODES_VERSION = 2; // from which blocks can be canonical

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
  count: number; // of the first Gaussians of the block; of nodes or of their control points
  scale: number[]; // per component; empty for f32
  bias: number[];
  delta: boolean;
  codec: string;
  offset: number; // within the block, bytes
  bytes: number;
}

export interface Block {
  name: string; // for messages: its file, or its place in the single file
  kind: "static" | "dynamic" | "canonical";
  file: string | null; // of a folder
  offset: number; // in a single file: from the end of the manifest, bytes
  bytes: number;
  crc32: number;
  visible: [number, number]; // t
  count: number;
  nodes: number; // motion nodes of a canonical block, else 0
  knots: number; // control points of each of them
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
  gaussians: { static: number; dynamic: number; canonical: number };
  background: Triple; // sRGB, 0 to 255
  splat: SplatRules;
  anchor: "clip" | "mean_time";
  cameras: Camera[];
  audio: string | null;
  blocks: Block[];
}

const MAX_COUNT = 2 ** 27; // Gaussians of a block: more do not fit any card
const MAX_BYTES = 2 ** 31;
const MAX_NODES = 1024; // the words of bindings hold no larger number (packing.ts)
const MAX_KNOTS = 256;
const MIN_KNOTS = 4; // control points that act on a node at a time

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

/** Rows of a stream of motion nodes; 0: it is one of Gaussians. */
export function nodeRows(name: string, block: { nodes: number; knots: number }): number {
  if (name === "node_position" || name === "node_log_radius") return block.nodes;
  const ofControls = name === "node_translation" || name === "node_rotation";
  return ofControls ? block.nodes * block.knots : 0;
}

function readStream(f: Fields, block: Omit<Block, "streams">): Stream {
  const name = f.text("name");
  const type = f.text("type");
  const components = f.size("components", 64);
  const scaled = /^u\d+$/.test(type);
  const stream: Stream = {
    name,
    type,
    components,
    count: f.size("count", nodeRows(name, block) || block.count),
    scale: scaled ? f.numbers("scale", components) : [],
    bias: scaled ? f.numbers("bias", components) : [],
    delta: f.flag("delta", false),
    codec: f.text("codec"),
    offset: f.size("offset", block.bytes),
    bytes: f.size("bytes", block.bytes),
  };
  if (stream.offset + stream.bytes > block.bytes)
    throw f.wrong("offset + bytes", `at most ${block.bytes}`, stream.offset + stream.bytes);
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

function readKind(f: Fields, version: number): Block["kind"] {
  const kind = f.text("kind");
  if (kind === "static" || kind === "dynamic") return kind;
  if (version < NODES_VERSION) throw f.wrong("kind", "static or dynamic", kind);
  if (kind !== "canonical") throw f.wrong("kind", "static, dynamic or canonical", kind);
  return kind;
}

function readBlock(f: Fields, i: number, version: number): Block {
  const kind = readKind(f, version);
  const carried = kind === "canonical";
  const file = localFile(f);
  const block: Omit<Block, "streams"> = {
    name: file ?? `block ${i}`,
    kind,
    file,
    offset: file === null ? f.size("offset", Number.MAX_SAFE_INTEGER) : 0,
    bytes: f.size("bytes", MAX_BYTES),
    crc32: f.size("crc32", 0xffffffff),
    visible: f.numbers("visible", 2) as [number, number],
    count: f.size("count", MAX_COUNT),
    nodes: carried ? f.size("nodes", MAX_NODES, 1) : 0,
    knots: carried ? f.size("knots", MAX_KNOTS, MIN_KNOTS) : 0,
  };
  return { ...block, streams: f.list("streams", (stream) => readStream(stream, block)) };
}

function readBlocks(f: Fields, version: number): Block[] {
  const blocks = f.list("blocks", (block, i) => readBlock(block, i, version));
  const carried = blocks.filter(({ kind }) => kind === "canonical").length;
  if (carried > 1) throw f.wrong("blocks", "at most one of kind canonical", carried);
  return blocks;
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
    gaussians: {
      static: counts.size("static", 2 ** 40),
      dynamic: counts.size("dynamic", 2 ** 40),
      canonical: counts.has("canonical") ? counts.size("canonical", 2 ** 40) : 0,
    },
    background: f.triple("background"),
    splat: readSplat(f.within("splat")),
    anchor,
    cameras: f.list("cameras", readCamera),
    audio: f.has("audio") ? f.text("audio") : null,
    blocks: readBlocks(f, version),
  };
}
