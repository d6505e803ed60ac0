// Packs a decoded block into the words of the textures that the shader reads (splat4d_shader.ts):
// 32 bytes a Gaussian, 16 more when it moves, 32 more when motion nodes carry it, 16 to 96 more for
// SH of degrees 1 to 3. Runs in a worker.
import { BINDINGS, type Carried } from "./bindings";
import type { MotionNodes } from "./motion_nodes";
import type { DecodedBlock } from "./tessera4d";

/** Texels of four words; `per`: texels a Gaussian has. */
export interface Words {
  words: Uint32Array<ArrayBuffer>;
  per: number;
}

export interface PackedBlock {
  count: number;
  moving: boolean;
  /** Gaussians that have SH of degree 1, 2, 3. */
  shCounts: [number, number, number];
  place: Words; // x, y, z; rotation
  look: Words; // halves: opacity, r; g, b; ln scales; ln time scale
  motion: Words; // velocity, time mean
  bindings: Words; // of each, the heaviest first: 22 bits of weight, 10 of the node
  nodes: MotionNodes | null;
  sh: [Words, Words, Words]; // halves: 9 of degree 1 and 7 of degree 2; the other 8; 21 of degree 3
}

/** Texels of a row; textures are filled to whole rows, and to whole layers beyond 2048 rows. */
export const ROW = 2048;

const MOST_WEIGHT = 2 ** 22 - 1;

const FLOAT = new Float32Array(1);
const BITS = new Uint32Array(FLOAT.buffer);

/** IEEE half, rounded to nearest even; too large becomes the largest, as a card cannot use ∞. */
export function halfBits(value: number): number {
  FLOAT[0] = value;
  const bits = BITS[0];
  const sign = (bits >>> 16) & 0x8000;
  const magnitude = bits & 0x7fffffff;
  if (magnitude > 0x7f800000) return sign; // not a number: 0
  if (magnitude >= 0x477ff000) return sign | 0x7bff;
  if (magnitude < 0x38800000) {
    // below 2^-14: steps of 2^-24
    const steps = Math.abs(FLOAT[0]) * 2 ** 24;
    const down = Math.floor(steps);
    const rest = steps - down;
    return sign | (down + (rest > 0.5 || (rest === 0.5 && down & 1) ? 1 : 0));
  }
  const rounded = magnitude + 0xfff + ((magnitude >>> 13) & 1);
  return sign | ((rounded - 0x38000000) >>> 13);
}

function halves(low: number, high: number): number {
  return (halfBits(low) | (halfBits(high) << 16)) >>> 0;
}

/** Index of the largest part, then the others in ten bits each: as fine as Spark keeps them. */
export function smallestThree(q: Float32Array, at: number): number {
  let largest = 0;
  for (let k = 1; k < 4; ++k) if (Math.abs(q[at + k]) > Math.abs(q[at + largest])) largest = k;
  const sign = q[at + largest] < 0 ? -1 : 1;
  let word = largest << 30;
  for (let k = 0, shift = 20; k < 4; ++k) {
    if (k === largest) continue;
    const step = Math.round(((sign * q[at + k]) / Math.SQRT2 + 0.5) * 1023);
    word |= Math.min(1023, Math.max(0, step)) << shift;
    shift -= 10;
  }
  return word >>> 0;
}

/** Words for `count` Gaussians, in whole rows. */
function texels(count: number, per: number): Words {
  const rows = Math.ceil((count * per) / ROW);
  const filled = rows > ROW ? Math.ceil(rows / ROW) * ROW : rows;
  return { words: new Uint32Array(filled * ROW * 4), per };
}

function packPlace(block: DecodedBlock): Words {
  const place = texels(block.count, 1);
  const floats = new Float32Array(place.words.buffer);
  for (let i = 0; i < block.count; ++i) {
    floats.set(block.position.subarray(3 * i, 3 * i + 3), 4 * i);
    place.words[4 * i + 3] = smallestThree(block.rotation, 4 * i);
  }
  return place;
}

function packLook(block: DecodedBlock, moving: boolean): Words {
  const look = texels(block.count, 1);
  const { opacity, colour, logScale, logTimeScale } = block;
  for (let i = 0, k = 0; i < block.count; ++i, k += 3) {
    look.words[4 * i] = halves(opacity[i], colour[k]);
    look.words[4 * i + 1] = halves(colour[k + 1], colour[k + 2]);
    look.words[4 * i + 2] = halves(logScale[k], logScale[k + 1]);
    look.words[4 * i + 3] = halves(logScale[k + 2], moving ? logTimeScale[i] : 0);
  }
  return look;
}

function packMotion(block: DecodedBlock, moving: boolean): Words {
  const motion = texels(moving ? block.count : 0, 1);
  const floats = new Float32Array(motion.words.buffer);
  for (let i = 0; moving && i < block.count; ++i) {
    floats.set(block.velocity.subarray(3 * i, 3 * i + 3), 4 * i);
    floats[4 * i + 3] = block.timeMean[i];
  }
  return motion;
}

/** No weight stands for no node. */
function packBindings(carried: Carried | null): Words {
  const count = (carried?.node.length ?? 0) / BINDINGS;
  const bindings = texels(count, BINDINGS / 4);
  if (carried === null) return bindings;
  const { node, weight } = carried;
  for (let i = 0; i < count; ++i) {
    const bound = Array.from({ length: BINDINGS }, (_, k) => BINDINGS * i + k)
      .filter((k) => weight[k] > 0)
      .sort((a, b) => weight[b] - weight[a]);
    bound.forEach((k, place) => {
      const steps = Math.round(weight[k] * MOST_WEIGHT);
      bindings.words[BINDINGS * i + place] = ((steps << 10) | node[k]) >>> 0;
    });
  }
  return bindings;
}

/** Values `from` to `to` of rows of `stride`, as halves from half `at` of a Gaussian's texels. */
function packHalves(
  target: Words,
  rows: Float32Array,
  [stride, from, to, at]: [number, number, number, number],
): void {
  const count = rows.length / stride;
  for (let i = 0; i < count; ++i)
    for (let k = from; k < to; ++k) {
      const half = i * target.per * 8 + at + k - from;
      target.words[half >> 1] |= halfBits(rows[i * stride + k]) << (half & 1 ? 16 : 0);
    }
}

export function packBlock(block: DecodedBlock): PackedBlock {
  const [sh1, sh2, sh3] = block.sh;
  const counts: [number, number, number] = [sh1.length / 9, sh2.length / 15, sh3.length / 21];
  const moving = block.velocity.length > 0;
  const low = texels(Math.max(counts[0], counts[1]), 2);
  const mid = texels(counts[1], 1);
  const high = texels(counts[2], 3);
  packHalves(low, sh1, [9, 0, 9, 0]);
  packHalves(low, sh2, [15, 0, 7, 9]);
  packHalves(mid, sh2, [15, 7, 15, 0]);
  packHalves(high, sh3, [21, 0, 21, 0]);
  return {
    count: block.count,
    moving,
    shCounts: counts,
    place: packPlace(block),
    look: packLook(block, moving),
    motion: packMotion(block, moving),
    bindings: packBindings(block.carried),
    nodes: block.carried?.nodes ?? null,
    sh: [low, mid, high],
  };
}

/** All words of a block: what a card keeps. */
function allWords(packed: PackedBlock): Words[] {
  return [packed.place, packed.look, packed.motion, packed.bindings, ...packed.sh];
}

/** All arrays of a block: what moves between threads. */
export function allArrays(packed: PackedBlock): (Uint32Array | Float32Array)[] {
  const { nodes } = packed;
  const ofNodes = nodes === null ? [] : [nodes.position, nodes.translation, nodes.rotation];
  return [...allWords(packed).map(({ words }) => words), ...ofNodes];
}

/** Of motion nodes at one time: two texels each, eight floats. */
export function poseTexels(nodes: MotionNodes | null): Words {
  return texels(nodes?.count ?? 0, 2);
}

/** Bytes of a block while it can be drawn. */
export function memoryOf(packed: PackedBlock): number {
  const arrays = [...allArrays(packed), poseTexels(packed.nodes).words];
  return arrays.reduce((sum, { byteLength }) => sum + byteLength, 0);
}
