// Motion nodes in the player: the reader of canonical blocks against a writer made from the
// specification and against invalid blocks, and splines and poses against known answers.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {playerModules} from './player_modules.mjs';
import {carriedStreams, makeBlock, makeManifest, plainStreams} from './tessera4d_writer.mjs';

const {decodeBlock, memoryOf, packBlock, readManifest, splineWeights, writePoses} =
    await playerModules('manifest', 'motion_nodes', 'packing', 'tessera4d');

const manifestOf = (blocks) => makeManifest(blocks, {version: 2});
const carriedBlock = (streams, more = {}) => makeBlock({kind: 'canonical', count: 2, file: 'a.bin',
  nodes: 2, knots: 4, streams: {...carriedStreams(2), ...streams}, ...more});

async function decoded(block) {
  const manifest = readManifest(manifestOf([block]), 'manifest.json');
  return decodeBlock(manifest.blocks[0], new Uint8Array(block.bytes));
}

function near(actual, expected, tolerance = 1e-6) {
  assert.equal(actual.length, expected.length);
  expected.forEach((value, k) => assert.ok(Math.abs(actual[k] - value) <= tolerance,
                                           `[${k}]: ${actual[k]}, expected ${value}`));
}

// Bugs put back: the rest given to the last node; rows of node_translation by the count of
// Gaussians; each seen to fail.
test('a canonical block decodes to nodes, bindings and weights', async () => {
  const controls = Array.from({length: 8}, (_, i) => [i, 2 * i, 100]);
  const {carried} = await decoded(carriedBlock({
    node: {type: 'u8', rows: [[2, 1, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0]],
           bias: Array(8).fill(-1)},
    node_weight: {type: 'u16', rows: [[256, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0]],
                  scale: Array(7).fill(1 / 1024)},
    node_translation: {type: 'u16', rows: controls, delta: true, scale: [0.5, 1, 1],
                       bias: [-1, 0, 0]},
  }));
  assert.deepEqual([...carried.node], [1, 0, ...Array(14).fill(-1)]);
  near([...carried.weight], [0.75, 0.25, ...Array(14).fill(0)]);  // the second has no node
  assert.deepEqual([carried.nodes.count, carried.nodes.knots], [2, 4]);
  assert.deepEqual([...carried.nodes.position], [0, 0, 0, 1, 0, 0]);
  assert.deepEqual([...carried.nodes.translation],
                   controls.flatMap(([x, y, z]) => [0.5 * x - 1, y, z]));
});

// Bugs put back: distances not squared; logits of no node counted; each seen to fail.
test('weights of lossless blocks are those of logits, distances and radii', async () => {
  const {node_weight, ...streams} = carriedStreams(2);
  const {carried} = await decoded(makeBlock({kind: 'canonical', count: 2, file: 'a.bin', nodes: 2,
    knots: 4, streams: {
      ...streams,
      position: {type: 'f32', rows: [[0, 0, 0], [3, 0, 0]]},
      node: {type: 'u8', rows: [[1, 2, 0, 0, 0, 0, 0, 0], [2, 0, 0, 1, 0, 0, 0, 0]],
             bias: Array(8).fill(-1)},
      node_logit: {type: 'f32', rows: [[Math.log(2), 1, 50, 0, 0, 0, 0, 0],
                                       [-1, 0, 0, 1, 0, 0, 0, 0]]},
      node_log_radius: {type: 'f32', rows: [[Math.log(2)], [Math.log(0.5)]]},
    }}));
  // node 0 at 0, radius 2; node 1 at 1, radius 1/2
  const [a, b] = [2, Math.exp(1 - 1 / (2 * 0.25))];
  const [c, d] = [Math.exp(-1 - 4 / (2 * 0.25)), Math.exp(1 - 9 / (2 * 4))];
  near([...carried.weight], [a / (a + b), b / (a + b), ...Array(6).fill(0),
                             c / (c + d), 0, 0, d / (c + d), ...Array(4).fill(0)]);
});

// Bugs put back: bindings in the order of the file; weights of ten bits; each seen to fail.
test('bindings go to the card with the heaviest first, and count as memory', async () => {
  const block = await decoded(carriedBlock({
    node: {type: 'u8', rows: [[1, 2, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0]],
           bias: Array(8).fill(-1)},
    node_weight: {type: 'f32', rows: [[0.7, 0, 0, 0, 0, 0, 0], Array(7).fill(0)]},
  }));
  const packed = packBlock(block);
  const bound = ([...words]) => words.map((word) => [word & 1023, (word >>> 10) / (2 ** 22 - 1)]);
  const [first, second, none] = bound(packed.bindings.words);
  assert.deepEqual([first[0], second[0], none[1]], [1, 0, 0]);
  near([first[1], second[1]], [0.7, 0.3], 2 ** -22);
  assert.ok(packed.bindings.words.subarray(8).every((word) => word === 0), 'bound to none');
  const still = packBlock({...block, carried: null});
  assert.equal(still.nodes, null);
  const {nodes} = packed;
  assert.equal(memoryOf(packed) - memoryOf(still), 4 * packed.bindings.words.length + 16 * 2048 +
               4 * (nodes.position.length + nodes.translation.length + nodes.rotation.length));
});

/** What is wrong, by the block that has it. */
const spoilt = (streams) => () => carriedBlock(streams);
const kWrong = {
  'a node that is not there':
    [spoilt({node: {type: 'u8', rows: Array(2).fill([3, 0, 0, 0, 0, 0, 0, 0]),
                    bias: Array(8).fill(-1)}}), /bound to node 2 of 2/],
  'a node below none':
    [spoilt({node: {type: 'u8', rows: Array(2).fill(Array(8).fill(0)), bias: Array(8).fill(-2)}}),
     /bound to node -2 of 2/],
  'half a node':
    [spoilt({node: {type: 'u8', rows: Array(2).fill(Array(8).fill(1)), scale: Array(8).fill(0.5)}}),
     /bound to node 0\.5 of 2/],
  'a node that is NaN':
    [spoilt({node: {type: 'f32', rows: Array(2).fill(Array(8).fill(NaN))}}), /to node NaN of 2/],
  'nodes of some Gaussians':
    [spoilt({node: {type: 'u8', rows: [Array(8).fill(0)]}}), /1 of 2 Gaussians have node/],
  'control points too few':
    [spoilt({node_rotation: {type: 'f32', rows: Array(7).fill([1, 0, 0, 0])}}),
     /node_rotation has 7 of 8 rows/],
  'a node that lies nowhere':
    [spoilt({node_position: {type: 'f32', rows: [[0, 0, 0], [NaN, 0, 0]]}}),
     /node_position has a value that is not finite/],
  'an endless weight':
    [spoilt({node_weight: {type: 'f32', rows: Array(2).fill(Array(7).fill(Infinity))}}),
     /node_weight has a value that is not finite/],
  'quaternions of three parts':
    [spoilt({node_rotation: {type: 'f32', rows: Array(8).fill([1, 0, 0])}}),
     /3 components, expected 4/],
  'no positions of nodes': [() => {
    const {node_position, ...streams} = carriedStreams(2);
    return makeBlock({kind: 'canonical', count: 2, file: 'a.bin', nodes: 2, knots: 4, streams});
  }, /node_position has 0 of 2 rows/],
  'logits without radii': [() => carriedBlock({node_logit: {type: 'f32',
    rows: Array(2).fill(Array(8).fill(0))}}), /node_log_radius has 0 of 2 rows/],
};

/** One line, of the shape "file: what; remedy". */
function refuses(error, pattern) {
  assert.equal(error.name, 'PlayerError', error.stack);
  assert.match(error.message, /^(manifest\.json|a\.bin)[^\n]*: [^\n]*; export[^\n]*$/);
  assert.match(error.message, pattern);
  return true;
}

// Bugs put back: numbers of nodes ignored; rows of control points not compared; values not
// checked; each seen to fail.
test('canonical blocks as they should not be', async (t) => {
  for (const [name, [make, pattern]] of Object.entries(kWrong))
    await t.test(name, () => assert.rejects(decoded(make()), (e) => refuses(e, pattern)));
});

const kManifests = {
  'in a file of version 1': [(m) => { m.version = 1; }, /kind should be static or dynamic/],
  'an unknown kind': [(m) => { m.blocks[0].kind = 'liquid'; }, /static, dynamic or canonical/],
  'no nodes': [(m) => { m.blocks[0].nodes = 0; }, /nodes should be an integer from 1 to 1024/],
  'nodes not said': [(m) => { delete m.blocks[0].nodes; }, /nodes should be an integer/],
  'more nodes than any scene': [(m) => { m.blocks[0].nodes = 1025; }, /nodes should be an integer/],
  'too few control points': [(m) => { m.blocks[0].knots = 3; }, /knots should be an integer from 4/],
  'endless control points': [(m) => { m.blocks[0].knots = 1e9; }, /knots should be an integer/],
  'more rows than control points': [(m) => { m.blocks[0].knots = 5;
    m.blocks[0].streams.find(({name}) => name === 'node_rotation').count = 11; },
    /count should be an integer from 0 to 10/],
  'two of them': [(m) => { m.blocks.push(m.blocks[0]); }, /at most one of kind canonical/],
};

// Bugs put back: canonical blocks let into version 1; no lower limits; more than one block; each
// seen to fail.
test('manifests of canonical blocks as they should not be', async (t) => {
  for (const [name, [spoil, pattern]] of Object.entries(kManifests))
    await t.test(name, () => {
      const manifest = structuredClone(manifestOf([carriedBlock({})]));
      spoil(manifest);
      assert.throws(() => readManifest(manifest, 'manifest.json'), (e) => refuses(e, pattern));
    });
  const mixed = [carriedBlock({}), makeBlock({count: 1, file: 'b.bin', streams: plainStreams(1)})];
  const {blocks} = readManifest(manifestOf(mixed), 'manifest.json');  // not spoilt
  assert.deepEqual(blocks.map(({kind, nodes, knots}) => [kind, nodes, knots]),
                   [['canonical', 2, 4], ['static', 0, 0]]);
});

/** B_i(t) as the specification writes it. */
function specified(i, t, knots) {
  const a = Math.abs(t * (knots - 3) + 1 - i);
  return a < 1 ? 2 / 3 - a ** 2 + a ** 3 / 2 : a < 2 ? (2 - a) ** 3 / 6 : 0;
}

// Bugs put back: S − 4 segments; t not clamped; weights in the opposite order; each seen to fail.
test('the spline is that of the specification, and its weights have the sum 1', () => {
  for (const knots of [4, 5, 14])
    for (const t of [-0.5, 0, 0.1, 1 / 3, 0.5, 0.999, 1, 7]) {
      const {first, weight} = splineWeights(t, knots);
      const all = Array(knots).fill(0);
      weight.forEach((w, i) => { all[first + i] = w; });
      const inside = Math.min(1, Math.max(0, t));
      near(all, Array.from({length: knots}, (_, i) => specified(i, inside, knots)), 1e-12);
      near([all.reduce((a, b) => a + b)], [1], 1e-12);
    }
});

/** Where a pose carries x. */
function carry([x, y, z, w, ...offset], v) {
  const matrix = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                  [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                  [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
  return matrix.map((row, c) => row.reduce((sum, m, k) => sum + m * v[k], offset[c]));
}

// Bugs put back: the node turned about the origin; quaternions of control points not normalised;
// a node read with the control points of another; each seen to fail.
test('a node turns by 90 degrees about its own place while it moves', () => {
  const half = Math.SQRT1_2;
  const ends = (from, to) => [from, from, from, to, to, to].flat();
  const poses = new Float32Array(16);
  const nodes = {count: 2, knots: 6,
    position: Float32Array.of(5, 5, 5, 1, 2, 0),
    translation: Float32Array.from([...Array(18).fill(0), ...ends([0, 0, 0], [0, 0, 3])]),
    rotation: Float32Array.from([...Array(24).fill(0), ...ends([2, 0, 0, 0], [half, 0, 0, half])])};
  writePoses(nodes, 0, poses);
  near([...poses.slice(8)], [0, 0, 0, 1, 0, 0, 0, 0]);
  writePoses(nodes, 1, poses);
  near([...poses.slice(8, 12)], [0, 0, half, half]);
  near(carry(poses.slice(8, 15), [2, 2, 4]), [1, 3, 7]);  // one beside the node; turned about z
  near([...poses.slice(0, 8)], [0, 0, 0, 1, 0, 0, 0, 0]);  // a blend of no length: unturned
  writePoses(nodes, 0.5, poses);  // B: 1/48, 23/48 on either side
  const part = [2, 0, 0, 0].map((w, k) => w / 2 + [half, 0, 0, half][k] / 2);
  const length = Math.hypot(...part);
  near([...poses.slice(8, 12)], [0, 0, part[3] / length, part[0] / length]);
  near(carry(poses.slice(8, 15), [1, 2, 0]), [1, 2, 1.5]);
});
