// The blocks of a manifest and their streams, listed in the manifest or, in a file of windows, at the
// beginning of each block. Numbers that pass need no further checks. Source:
// docs/reference/tessera4d.md, sections 3 and 4.
import { Fields } from "./json_fields";
import { PlayerError } from "./player_error";
import { drawnSpan, type Window } from "./windows";

const NODES_VERSION = 2; // in which blocks can be canonical
const MAX_COUNT = 2 ** 27; // Gaussians of a block: more do not fit any card
const MAX_BYTES = 2 ** 31;
const MAX_NODES = 1024; // the words of bindings hold no larger number (packing.ts)
const MAX_KNOTS = 256;
const MIN_KNOTS = 4; // control points that act on a node at a time

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
  visible: [number, number]; // t of the clip
  /** Index of the window that the block belongs to; null: of none, its time is that of the clip. */
  window: number | null;
  /** t of the clip from which to before which its window is drawn; null: always. */
  drawn: [number, number] | null;
  count: number;
  nodes: number; // motion nodes of a canonical block, else 0
  knots: number; // control points of each of them
  /** Bytes at the beginning of the block that list its streams; 0: the manifest lists them. */
  head: number;
  streams: Stream[]; // none where the block has a head
}

/** Rows of a stream of motion nodes; 0: it is one of Gaussians. */
export function nodeRows(name: string, block: { nodes: number; knots: number }): number {
  if (name === "node_position" || name === "node_log_radius") return block.nodes;
  const ofControls = name === "node_translation" || name === "node_rotation";
  return ofControls ? block.nodes * block.knots : 0;
}

/** `data`: bytes of the block without its head. */
function readStream(f: Fields, block: Omit<Block, "streams">, data: number): Stream {
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
    offset: f.size("offset", data),
    bytes: f.size("bytes", data),
  };
  if (stream.offset + stream.bytes > data)
    throw f.wrong("offset + bytes", `at most ${data}`, stream.offset + stream.bytes);
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
  // motion nodes came with version 2, and a file of windows has none
  if (version !== NODES_VERSION) throw f.wrong("kind", "static or dynamic", kind);
  if (kind !== "canonical") throw f.wrong("kind", "static, dynamic or canonical", kind);
  return kind;
}

/** The window of a block in a file of windows: of each dynamic block, and of no other. */
function readWindow(f: Fields, kind: Block["kind"], windows: readonly Window[]): number | null {
  if (windows.length === 0) return null;
  if (kind === "dynamic") return f.size("window", windows.length - 1);
  if (f.has("window")) throw f.wrong("window", "absent from a static block", f.raw("window"));
  return null;
}

/** What of `visible` lies where the block is drawn. */
function visibleWithin(f: Fields, drawn: [number, number] | null): [number, number] {
  const [from, to] = f.numbers("visible", 2);
  if (drawn === null) return [from, to];
  const visible: [number, number] = [Math.max(from, drawn[0]), Math.min(to, drawn[1])];
  if (visible[0] > visible[1])
    throw f.wrong("visible", `within its window (${drawn.join(" to ")})`, [from, to]);
  return visible;
}

function readBlock(f: Fields, i: number, version: number, windows: readonly Window[]): Block {
  const kind = readKind(f, version);
  const carried = kind === "canonical";
  const file = localFile(f);
  const bytes = f.size("bytes", MAX_BYTES);
  const window = readWindow(f, kind, windows);
  const drawn = window === null ? null : drawnSpan(windows, window);
  const block: Omit<Block, "streams"> = {
    name: file ?? `block ${i}`,
    kind,
    file,
    offset: file === null ? f.size("offset", Number.MAX_SAFE_INTEGER) : 0,
    bytes,
    crc32: f.size("crc32", 0xffffffff),
    visible: visibleWithin(f, drawn),
    window,
    drawn,
    count: f.size("count", MAX_COUNT),
    nodes: carried ? f.size("nodes", MAX_NODES, 1) : 0,
    knots: carried ? f.size("knots", MAX_KNOTS, MIN_KNOTS) : 0,
    head: windows.length > 0 ? f.size("head", bytes, 1) : 0,
  };
  if (block.head > 0) return { ...block, streams: [] };
  return { ...block, streams: f.list("streams", (stream) => readStream(stream, block, bytes)) };
}

/** `windows`: of a file of version 3, else none. */
export function readBlocks(f: Fields, version: number, windows: readonly Window[]): Block[] {
  const blocks = f.list("blocks", (block, i) => readBlock(block, i, version, windows));
  const carried = blocks.filter(({ kind }) => kind === "canonical").length;
  if (carried > 1) throw f.wrong("blocks", "at most one of kind canonical", carried);
  return blocks;
}

/**
 * The block with the streams that its head lists, and the bytes behind the head. A block without a
 * head is returned as it is. `bytes`: of the block alone. Throws PlayerError.
 */
export function openHead(block: Block, bytes: Uint8Array): { block: Block; data: Uint8Array } {
  if (block.head === 0) return { block, data: bytes };
  let json: unknown;
  try {
    json = JSON.parse(new TextDecoder().decode(bytes.subarray(0, block.head)));
  } catch {
    throw new PlayerError(`${block.name}: its head is no JSON; export the scene again`);
  }
  const data = bytes.subarray(block.head);
  const head = new Fields(json, block.name, "");
  const streams = head.list("streams", (stream) => readStream(stream, block, data.length));
  return { block: { ...block, streams }, data };
}
