// What: the bytes of one block of a Tessera 4D file -> numbers of its Gaussians; crc, counts and
//       lengths are checked, so that no file makes it read or reserve what is not there.
// Not: fetching (container.ts), nor how a card wants the numbers (packing.ts).
// Source: docs/reference/tessera4d.md, sections 3 and 4.
import type { Block, Stream } from "./manifest";
import { PlayerError } from "./player_error";

export interface DecodedBlock {
  count: number;
  position: Float32Array; // [count, 3] world units, at the anchor
  rotation: Float32Array; // [count, 4] w, x, y, z, unit
  logScale: Float32Array; // [count, 3]
  opacity: Float32Array; // [count] 0 to 1
  colour: Float32Array; // [count, 3] SH of degree 0
  /** Degrees 1, 2, 3: [first Gaussians, 3 | 5 | 7 coefficients, 3 colours]. */
  sh: [Float32Array, Float32Array, Float32Array];
  velocity: Float32Array; // [count, 3] world units per t; empty for static blocks, as the two below
  timeMean: Float32Array; // [count] t
  logTimeScale: Float32Array; // [count]
}

const BYTES_OF: Record<string, number> = { u8: 1, u16: 2, u24: 3, u32: 4, f32: 4 };

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

/** As in gzip. */
export function crc32(bytes: Uint8Array): number {
  let c = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) c = CRC_TABLE[(c ^ bytes[i]) & 0xff] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

/** Throws PlayerError unless these are the bytes that the manifest promises. */
export function checkBytes(block: Block, bytes: Uint8Array): void {
  if (bytes.length !== block.bytes)
    throw new PlayerError(
      `${block.name}: ${bytes.length} bytes of ${block.bytes}, so it is cut off or of another ` +
        `export; copy the export again`,
    );
  if (crc32(bytes) !== block.crc32)
    throw new PlayerError(
      `${block.name}: the checksum differs from the manifest's, so it is damaged; ` +
        `copy the export again`,
    );
}

/** One gzip member that must hold exactly `size` bytes; stops as soon as it holds more. */
async function gunzip(packed: Uint8Array, size: number, where: string): Promise<Uint8Array> {
  const out = new Uint8Array(size);
  const damaged = (what: string) =>
    new PlayerError(`${where}: ${what}, so it is damaged; export the scene again`);
  const stream = new Blob([packed as BlobPart]).stream();
  const reader = stream.pipeThrough(new DecompressionStream("gzip")).getReader();
  let filled = 0;
  for (;;) {
    let part: ReadableStreamReadResult<Uint8Array>;
    try {
      part = await reader.read();
    } catch {
      throw damaged("gzip ends early or is broken");
    }
    if (part.done) break;
    if (filled + part.value.length > size) {
      await reader.cancel();
      throw damaged(`more than the ${size} bytes that its count asks for`);
    }
    out.set(part.value, filled);
    filled += part.value.length;
  }
  if (filled !== size) throw damaged(`${filled} bytes of the ${size} that its count asks for`);
  return out;
}

/** The planes of a stream, after its codec. */
async function planesOf(stream: Stream, block: Block, bytes: Uint8Array): Promise<Uint8Array> {
  const where = `${block.name}, ${stream.name}`;
  const width = BYTES_OF[stream.type];
  if (width === undefined)
    throw new PlayerError(`${where}: type "${stream.type}" is not known here; take a newer player`);
  const size = stream.count * stream.components * width;
  const packed = bytes.subarray(stream.offset, stream.offset + stream.bytes);
  if (stream.codec === "gzip") return gunzip(packed, size, where);
  if (stream.codec !== "none")
    throw new PlayerError(
      `${where}: codec "${stream.codec}" is not known here; take a newer player`,
    );
  if (packed.length !== size)
    throw new PlayerError(`${where}: ${packed.length} bytes, expected ${size}; export again`);
  return packed;
}

/** Component c of all Gaussians: bytes put together and, where stored so, differences undone. */
function integersOf(stream: Stream, planes: Uint8Array, c: number): Uint32Array {
  const n = stream.count;
  const width = BYTES_OF[stream.type];
  const values = new Uint32Array(n);
  for (let b = 0; b < width; ++b) {
    const plane = planes.subarray((c * width + b) * n, (c * width + b + 1) * n);
    const shift = 8 * b;
    for (let i = 0; i < n; ++i) values[i] |= plane[i] << shift;
  }
  if (stream.delta) {
    const mask = width === 4 ? 0xffffffff : 2 ** (8 * width) - 1;
    let last = 0;
    for (let i = 0; i < n; ++i) {
      const z = values[i];
      last = (last + ((z >>> 1) ^ -(z & 1))) & mask;
      values[i] = last;
    }
  }
  return values;
}

/** Unit quaternions (w, x, y, z) of three parts each; `largest`: index of the fourth. */
function completed(parts: Float32Array, largest: Float32Array): Float32Array {
  const rotation = new Float32Array(4 * largest.length);
  for (let i = 0; i < largest.length; ++i) {
    const left = largest[i] & 3;
    let rest = 1;
    for (let k = 0, part = 3 * i; k < 4; ++k) {
      if (k === left) continue;
      const value = parts[part++];
      rotation[4 * i + k] = value;
      rest -= value * value;
    }
    rotation[4 * i + left] = Math.sqrt(Math.max(0, rest));
  }
  return normalised(rotation);
}

function normalised(rotation: Float32Array): Float32Array {
  for (let i = 0; i < rotation.length; i += 4) {
    const length = Math.hypot(rotation[i], rotation[i + 1], rotation[i + 2], rotation[i + 3]);
    for (let k = 0; k < 4; ++k) rotation[i + k] /= length || 1;
  }
  return rotation;
}

/** Values of a stream, Gaussian by Gaussian. */
async function valuesOf(stream: Stream, block: Block, bytes: Uint8Array): Promise<Float32Array> {
  const planes = await planesOf(stream, block, bytes);
  const values = new Float32Array(stream.count * stream.components);
  for (let c = 0; c < stream.components; ++c) {
    const integers = integersOf(stream, planes, c);
    const floats = stream.type === "f32" ? new Float32Array(integers.buffer) : null;
    const scale = stream.scale[c];
    const bias = stream.bias[c];
    for (let i = 0, k = c; i < stream.count; ++i, k += stream.components)
      values[k] = floats ? floats[i] : bias + scale * integers[i];
  }
  return values;
}

/** Reads streams of one block by name. */
class StreamReader {
  constructor(
    private readonly block: Block,
    private readonly bytes: Uint8Array,
  ) {}
  private find(name: string): Stream | undefined {
    return this.block.streams.find((stream) => stream.name === name);
  }
  has(name: string): boolean {
    return this.find(name) !== undefined;
  }
  private async read(stream: Stream, components: number): Promise<Float32Array> {
    if (stream.components !== components)
      throw new PlayerError(
        `${this.block.name}, ${stream.name}: ${stream.components} components, ` +
          `expected ${components}; export the scene again`,
      );
    return valuesOf(stream, this.block, this.bytes);
  }
  /** A stream that each Gaussian must have. */
  async all(name: string, components: number): Promise<Float32Array> {
    const stream = this.find(name);
    if (stream === undefined || stream.count !== this.block.count)
      throw new PlayerError(
        `${this.block.name}: ${stream?.count ?? 0} of ${this.block.count} Gaussians have ` +
          `${name}; export the scene again`,
      );
    return this.read(stream, components);
  }
  /** A stream that the first Gaussians may have. */
  async first(name: string, components: number): Promise<Float32Array> {
    const stream = this.find(name);
    return stream ? this.read(stream, components) : new Float32Array(0);
  }
}

/** All four parts of each; or all but the largest, and which that is. */
async function readRotation(reader: StreamReader): Promise<Float32Array> {
  if (!reader.has("rotation_largest")) return normalised(await reader.all("rotation", 4));
  const largest = await reader.all("rotation_largest", 1);
  return completed(await reader.all("rotation", 3), largest);
}

async function readOpacity(reader: StreamReader): Promise<Float32Array> {
  if (!reader.has("opacity_logit")) return reader.all("opacity", 1);
  return (await reader.all("opacity_logit", 1)).map((logit) => 1 / (1 + Math.exp(-logit)));
}

/**
 * Checks and decodes one block. `bytes`: of the block alone.
 * Throws PlayerError with the block and the stream named.
 */
export async function decodeBlock(block: Block, bytes: Uint8Array): Promise<DecodedBlock> {
  checkBytes(block, bytes);
  const reader = new StreamReader(block, bytes);
  const moving = block.kind === "dynamic";
  const none = new Float32Array(0);
  return {
    count: block.count,
    position: await reader.all("position", 3),
    rotation: await readRotation(reader),
    logScale: await reader.all("log_scale", 3),
    opacity: await readOpacity(reader),
    colour: await reader.all("colour", 3),
    sh: [
      await reader.first("sh1", 9),
      await reader.first("sh2", 15),
      await reader.first("sh3", 21),
    ],
    velocity: moving ? await reader.all("velocity", 3) : none,
    timeMean: moving ? await reader.all("time_mean", 1) : none,
    logTimeScale: moving ? await reader.all("log_time_scale", 1) : none,
  };
}
