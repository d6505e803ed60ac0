// The motion nodes of a canonical block, and the nodes and weights that carry each Gaussian.
// Source: docs/reference/tessera4d.md, section 4.1.
import type { Block } from "./manifest_blocks";
import type { MotionNodes } from "./motion_nodes";
import { PlayerError } from "./player_error";
import { finite, type StreamReader } from "./streams";

/** Nodes that a Gaussian can be bound to. */
export const BINDINGS = 8;

export interface Carried {
  nodes: MotionNodes;
  node: Int16Array; // [count, 8]; −1: none
  weight: Float32Array; // [count, 8] 0 where there is no node; the sum is 1 where there is one
}

async function readNodes(reader: StreamReader, { nodes, knots }: Block): Promise<MotionNodes> {
  return {
    count: nodes,
    knots,
    position: await reader.ofNodes("node_position", 3),
    translation: await reader.ofNodes("node_translation", 3),
    rotation: await reader.ofNodes("node_rotation", 4),
  };
}

async function readIds(reader: StreamReader, block: Block): Promise<Int16Array> {
  const ids = await reader.all("node", BINDINGS);
  const wrong = ids.find((id) => !(Number.isInteger(id) && id >= -1 && id < block.nodes));
  if (wrong !== undefined)
    throw new PlayerError(
      `${block.name}: a Gaussian is bound to node ${wrong} of ${block.nodes}; ` +
        `export the scene again`,
    );
  return Int16Array.from(ids);
}

/** What is left of 1 goes to the first node. */
async function readShares(reader: StreamReader, block: Block): Promise<Float32Array> {
  const rest = finite(await reader.all("node_weight", BINDINGS - 1), "node_weight", block);
  const shares = new Float32Array(BINDINGS * block.count);
  for (let i = 0; i < block.count; ++i) {
    const row = rest.subarray((BINDINGS - 1) * i, (BINDINGS - 1) * (i + 1));
    shares[BINDINGS * i] = row.reduce((left, share) => left - share, 1);
    shares.set(row, BINDINGS * i + 1);
  }
  return shares;
}

/** exp(f − ‖x − p‖² / (2 r²)), by the largest of each Gaussian; 0 where there is no node. */
async function sharesOfLogits(
  reader: StreamReader,
  block: Block,
  ids: Int16Array,
  place: Float32Array, // [count, 3] Gaussians at rest
  centre: Float32Array, // [nodes, 3]
): Promise<Float32Array> {
  const logits = finite(await reader.all("node_logit", BINDINGS), "node_logit", block);
  const logRadius = await reader.ofNodes("node_log_radius", 1);
  const shares = new Float32Array(BINDINGS * block.count);
  const exponents = new Float64Array(BINDINGS);
  for (let i = 0; i < block.count; ++i) {
    for (let k = 0; k < BINDINGS; ++k) {
      const node = ids[BINDINGS * i + k];
      let distance2 = 0;
      for (let c = 0; node >= 0 && c < 3; ++c)
        distance2 += (place[3 * i + c] - centre[3 * node + c]) ** 2;
      exponents[k] =
        node < 0
          ? -Infinity
          : logits[BINDINGS * i + k] - 0.5 * Math.exp(-2 * logRadius[node]) * distance2;
    }
    const largest = Math.max(...exponents);
    if (largest === -Infinity) continue;
    for (let k = 0; k < BINDINGS; ++k)
      shares[BINDINGS * i + k] = Math.exp(exponents[k] - largest);
  }
  return shares;
}

/** Weights of sum 1 from shares; what is not above 0 or of no node does not count. */
function weightsOf(ids: Int16Array, shares: Float32Array): Float32Array {
  const weight = shares.map((share, k) => (ids[k] >= 0 && share > 0 ? share : 0));
  for (let first = 0; first < weight.length; first += BINDINGS) {
    const row = weight.subarray(first, first + BINDINGS);
    const sum = row.reduce((a, b) => a + b, 0);
    if (sum > 0) row.forEach((w, k) => (row[k] = w / sum));
  }
  return weight;
}

/** `place`: [count, 3] of the Gaussians at rest. Throws PlayerError. */
export async function readCarried(
  reader: StreamReader,
  block: Block,
  place: Float32Array,
): Promise<Carried> {
  const nodes = await readNodes(reader, block);
  const node = await readIds(reader, block);
  const shares = reader.has("node_logit")
    ? await sharesOfLogits(reader, block, node, place, nodes.position)
    : await readShares(reader, block);
  return { nodes, node, weight: weightsOf(node, shares) };
}
