// Decodes the bytes of one block of a Tessera 4D file to the numbers of its Gaussians, after a
// check of length and checksum. Source: docs/reference/tessera4d.md, sections 3 and 4.
import { readCarried, type Carried } from "./bindings";
import { openHead, type Block } from "./manifest_blocks";
import { PlayerError } from "./player_error";
import { StreamReader } from "./streams";

export interface DecodedBlock {
  count: number;
  position: Float32Array; // [count, 3] world units, at the anchor
  rotation: Float32Array; // [count, 4] w, x, y, z, unit
  logScale: Float32Array; // [count, 3]
  opacity: Float32Array; // [count] 0 to 1
  colour: Float32Array; // [count, 3] SH of degree 0
  /** Degrees 1, 2, 3: [first Gaussians, 3 | 5 | 7 coefficients, 3 colours]. */
  sh: [Float32Array, Float32Array, Float32Array];
  velocity: Float32Array; // [count, 3] world units per unit of its time; empty for static blocks, as the two below
  timeMean: Float32Array; // [count] in its time: t, or tau of its window
  logTimeScale: Float32Array; // [count]
  carried: Carried | null; // of canonical blocks
}

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
 * Checks and decodes one block. `entry`: as its manifest has it; `bytes`: of the block alone.
 * Throws PlayerError with the block and the stream named.
 */
export async function decodeBlock(entry: Block, bytes: Uint8Array): Promise<DecodedBlock> {
  checkBytes(entry, bytes);
  const { block, data } = openHead(entry, bytes);
  const reader = new StreamReader(block, data);
  const moving = block.kind === "dynamic";
  const none = new Float32Array(0);
  const position = await reader.all("position", 3);
  return {
    count: block.count,
    position,
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
    carried: block.kind === "canonical" ? await readCarried(reader, block, position) : null,
  };
}
