// Motion nodes at a time: uniform cubic B-splines of control points to poses, as the texels that
// the shader reads (carry_shader.ts). Source: docs/reference/tessera4d.md, sections 1 and 4.1.

export interface MotionNodes {
  count: number;
  knots: number; // control points of each, at least 4
  position: Float32Array; // [count, 3] at rest, world units
  translation: Float32Array; // [count, knots, 3] world units
  rotation: Float32Array; // [count, knots, 4] w, x, y, z
}

/** Control points that act at a time: weight[i] belongs to control point first + i. */
export interface SplineWeights {
  first: number;
  weight: [number, number, number, number]; // the sum is 1
}

const SHORTEST2 = 1e-8; // a blend of quaternions below this squared length leaves its node unturned

export function splineWeights(t: number, knots: number): SplineWeights {
  const segments = knots - 3;
  const u = Math.min(1, Math.max(0, t)) * segments;
  const first = Math.min(Math.floor(u), segments - 1);
  const f = u - first;
  const rest = 1 - f;
  return {
    first,
    weight: [
      rest ** 3 / 6,
      2 / 3 - f ** 2 + f ** 3 / 2,
      2 / 3 - rest ** 2 + rest ** 3 / 2,
      f ** 3 / 6,
    ],
  };
}

/** Component c of Σ weight[i] · row first + i of `rows`, of a node whose rows begin at `from`. */
function blend(
  { first, weight }: SplineWeights,
  rows: Float32Array,
  [from, width, c]: [number, number, number],
): number {
  let sum = 0;
  for (let i = 0; i < 4; ++i) sum += weight[i] * rows[(from + first + i) * width + c];
  return sum;
}

/** v turned by the unit quaternion. */
function turned([w, x, y, z]: number[], [a, b, c]: number[]): number[] {
  // twice the cross product of (x, y, z) and v
  const p = 2 * (y * c - z * b);
  const q = 2 * (z * a - x * c);
  const r = 2 * (x * b - y * a);
  return [a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p];
}

/**
 * Writes eight floats a node: its unit quaternion q as x, y, z, w; τ = p + T − R(q) p and 0, so that
 * it carries x to R x + τ. Beyond 0 to 1 t counts as the nearer end.
 */
export function writePoses(nodes: MotionNodes, t: number, out: Float32Array): void {
  const spline = splineWeights(t, nodes.knots);
  for (let n = 0; n < nodes.count; ++n) {
    const from = n * nodes.knots;
    let q = [0, 1, 2, 3].map((c) => blend(spline, nodes.rotation, [from, 4, c]));
    const length = Math.hypot(...q);
    q = length ** 2 >= SHORTEST2 ? q.map((part) => part / length) : [1, 0, 0, 0];
    const rest = [...nodes.position.subarray(3 * n, 3 * n + 3)];
    const rotated = turned(q, rest);
    out.set([q[1], q[2], q[3], q[0]], 8 * n);
    for (let c = 0; c < 3; ++c)
      out[8 * n + 4 + c] =
        rest[c] + blend(spline, nodes.translation, [from, 3, c]) - rotated[c];
    out[8 * n + 7] = 0;
  }
}
