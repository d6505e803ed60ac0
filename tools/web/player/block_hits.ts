// The Gaussians of a packed block that a ray intersects at one time. Gaussians that motion nodes
// carry are taken at the place that their file states, without the nodes.
import * as THREE from "three";
import type { PackedBlock } from "./packing";
import { hitOf, type Hit, type Ray } from "./pick";

const FAINTEST = 0.05; // opacity that is looked at

const low = (word: number) => THREE.DataUtils.fromHalfFloat(word & 0xffff);
const high = (word: number) => THREE.DataUtils.fromHalfFloat(word >>> 16);

/** `t`: the block's own time; `clip`: anchors of motion are clamped to the clip, as in splat4d_shader.ts. */
export function blockHits(packed: PackedBlock, ray: Ray, t: number, clip: boolean): Hit[] {
  const look = packed.look.words;
  const place = new Float32Array(packed.place.words.buffer);
  const motion = new Float32Array(packed.motion.words.buffer);
  const hits: Hit[] = [];
  for (let i = 0, k = 0; i < packed.count; ++i, k += 4) {
    let opacity = low(look[k]);
    let elapsed = 0;
    if (packed.moving) {
      const mean = motion[k + 3];
      const sigmas = (t - mean) * Math.exp(-high(look[k + 3]));
      opacity *= Math.exp(-0.5 * sigmas * sigmas);
      elapsed = t - (clip ? Math.min(1, Math.max(0, mean)) : mean);
    }
    if (opacity < FAINTEST) continue;
    const [x, y, z] = [0, 1, 2].map(
      (a) => place[k + a] + (packed.moving ? motion[k + a] * elapsed : 0),
    );
    const size = Math.exp(Math.max(low(look[k + 2]), high(look[k + 2]), low(look[k + 3])));
    const hit = hitOf(ray, x, y, z, size, opacity);
    if (hit !== null) hits.push(hit);
  }
  return hits;
}
