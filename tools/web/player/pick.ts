// The depth of the scene along a ray of the view, from the centres, sizes and opacities of the
// Gaussians: where those around the ray cover half of what lies behind them.
import * as THREE from "three";

const HALF = 0.5; // transmittance that is left at the depth that is chosen
const CONE = 0.004; // tangent of the angle from the ray within which small Gaussians count
const WIDTH = 1.5; // standard deviations within which large ones count

export interface Ray {
  origin: THREE.Vector3;
  direction: THREE.Vector3; // of length 1
}

export interface Hit {
  depth: number; // along the ray
  opacity: number;
}

/** A Gaussian's centre, largest standard deviation and opacity; null where the ray misses it. */
export function hitOf(
  ray: Ray,
  x: number,
  y: number,
  z: number,
  size: number,
  opacity: number,
): Hit | null {
  const { origin, direction } = ray;
  const [dx, dy, dz] = [x - origin.x, y - origin.y, z - origin.z];
  const depth = dx * direction.x + dy * direction.y + dz * direction.z;
  if (depth <= 0) return null;
  const aside = dx * dx + dy * dy + dz * dz - depth * depth;
  const reach = Math.max(CONE * depth, WIDTH * size);
  return aside > reach * reach ? null : { depth, opacity };
}

/** null: nothing is met. */
export function firstDepth(hits: Hit[]): number | null {
  let left = 1;
  for (const { depth, opacity } of hits.sort((a, b) => a.depth - b.depth)) {
    left *= 1 - opacity;
    if (left <= HALF) return depth;
  }
  return null;
}
