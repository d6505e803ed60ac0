// The player's reader of Tessera 4D files against a writer made from the specification and against
// invalid files; each invalid file gives one line with the file and the remedy.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {gzipSync} from 'node:zlib';
import {playerModules} from './player_modules.mjs';
import {makeBlock, makeManifest, makeSingle, movingStreams,
        plainStreams} from './tessera4d_writer.mjs';

const {bytesSource, decodeBlock, halfBits, packBlock, parseJson, readManifest, smallestThree} =
    await playerModules('container', 'manifest', 'packing', 'tessera4d');

/** The block as the manifest of its file says it, decoded. */
async function decoded(block) {
  const manifest = readManifest(makeManifest([block]), 'manifest.json');
  return decodeBlock(manifest.blocks[0], new Uint8Array(block.bytes));
}

// Bug put back: planes from the highest byte, z >> 1 without ^ −(z & 1), the largest part of a
// rotation taken to be w, bias left away; each seen to fail.
test('a block decodes to the numbers it was made of', async () => {
  const positions = [[0, 5, 70000], [16777215, 4, 3], [9, 3, 16000000]];
  const block = makeBlock({kind: 'dynamic', count: 3, file: 'a.bin', streams: {
    ...movingStreams(3),
    position: {type: 'u24', rows: positions, delta: true, scale: [0.5, 1, 2], bias: [-1, 0, 10]},
    rotation: {type: 'u16', rows: [[2000, 3000, 4], [2048, 2048, 2048], [0, 0, 0]], delta: true,
               scale: [1, 1, 1].map((n) => n / 4096), bias: [-0.5, -0.5, 0]},
    rotation_largest: {type: 'u8', rows: [[1], [3], [0]]},
    opacity: {type: 'u8', rows: [[0], [128], [255]], scale: [1 / 255], codec: 'none'},
    sh1: {type: 'u16', rows: [[0, 1, 2, 3, 4, 5, 6, 7, 65535]], scale: Array(9).fill(2),
          bias: Array(9).fill(-3)},
    velocity: {type: 'f32', rows: [[1.5, -2.25, 1e-3], [0, 0, 0], [1, 2, 3]]},
    something_new: {type: 'q7', rows: [[1]], codec: 'none'},
  }});
  const values = await decoded(block);
  const expected = positions.flatMap(([x, y, z]) => [x * 0.5 - 1, y, 2 * z + 10]);
  assert.deepEqual([...values.position], expected.map(Math.fround));
  const [w, y, z] = [2000 / 4096 - 0.5, 3000 / 4096 - 0.5, 4 / 4096];
  const x = Math.sqrt(1 - w * w - y * y - z * z);
  [w, x, y, z].forEach((v, k) => assert.ok(Math.abs(values.rotation[k] - v) < 1e-6, `part ${k}`));
  assert.deepEqual([...values.opacity], [0, 128 / 255, 1].map(Math.fround));
  assert.deepEqual([...values.sh[0]], [-3, -1, 1, 3, 5, 7, 9, 11, 131067]);
  assert.deepEqual([...values.velocity.slice(0, 3)], [1.5, -2.25, 1e-3].map(Math.fround));
  assert.equal(values.sh[1].length, 0);
  assert.deepEqual([...values.timeMean], [0.5, 0.5, 0.5]);
});

// Bug put back: the logit taken as the opacity; seen to fail.
test('lossless blocks hold logits and quaternions of any length', async () => {
  const {opacity, rotation, ...streams} = plainStreams(2);
  const values = await decoded(makeBlock({count: 2, file: 'a.bin', streams: {
    ...streams,
    rotation: {type: 'f32', rows: [[0, 3, 0, 0], [1, 1, 1, 1]]},
    opacity_logit: {type: 'f32', rows: [[0], [Math.log(3)]]},
  }}));
  assert.deepEqual([...values.rotation], [0, 1, 0, 0, 0.5, 0.5, 0.5, 0.5]);
  assert.ok(Math.abs(values.opacity[0] - 0.5) < 1e-7 && Math.abs(values.opacity[1] - 0.75) < 1e-7);
});

// Bugs put back: halves cut off instead of rounded, the sign of the largest part ignored; each seen
// to fail.
test('the data uploaded to the device', () => {
  for (const [value, bits] of [[1, 0x3c00], [-2, 0xc000], [65504, 0x7bff], [1e9, 0x7bff],
                               [2 ** -24, 1], [1.0004887, 0x3c01], [0.1, 0x2e66], [NaN, 0]])
    assert.equal(halfBits(value), bits, `${value}`);
  const tau = Math.SQRT1_2;
  assert.equal(smallestThree(Float32Array.of(-tau, 0, -tau, 0), 0),
               smallestThree(Float32Array.of(tau, 0, tau, 0), 0));
  const none = new Float32Array(0);
  const sh1 = Float32Array.from({length: 18}, (_, k) => k);
  const sh2 = Float32Array.from({length: 15}, (_, k) => 100 + k);
  const packed = packBlock({count: 2, position: Float32Array.of(1, 2, 3, 4, 5, 6),
    rotation: Float32Array.of(1, 0, 0, 0, 1, 0, 0, 0), logScale: new Float32Array(6),
    opacity: Float32Array.of(1, 0.5), colour: new Float32Array(6), sh: [sh1, sh2, none],
    velocity: none, timeMean: none, logTimeScale: none, carried: null});
  assert.deepEqual(packed.shCounts, [2, 1, 0]);
  assert.equal(packed.sh[0].words[4] >>> 16, halfBits(100));      // ninth half: degree 2 begins
  assert.equal(packed.sh[1].words[0] & 0xffff, halfBits(107));    // and continues
  assert.equal(packed.sh[0].words[8] & 0xffff, halfBits(9));      // the second Gaussian
  assert.equal(new Float32Array(packed.place.words.buffer)[4], 4);
});

const good = () => makeBlock({count: 4, file: 'a.bin', streams: plainStreams(4)});

/** One line, of the shape "file: what; remedy". */
function refuses(error, pattern) {
  assert.equal(error.name, 'PlayerError', error.stack);
  assert.doesNotMatch(error.message, /\n/);
  assert.match(error.message, /^(manifest\.json|a\.bin|scene\.t4d)/);
  assert.match(error.message, /; |: copy/);
  assert.match(error.message, pattern);
  return true;
}

const kManifests = {
  'another format': [(m) => { m.format = '3dgs'; }, /format should be "tessera-4d"/],
  'a later version': [(m) => { m.version = 4; }, /version 4 is later/],
  'a version that is no number': [(m) => { m.version = '1'; }, /version should be an integer/],
  'no blocks but a number': [(m) => { m.blocks = 7; }, /blocks should be a list/],
  'a block that is null': [(m) => { m.blocks[0] = null; }, /blocks\[0\] should be an object/],
  'a count beyond any card': [(m) => { m.blocks[0].count = 2 ** 40; }, /count should be an integer/],
  'a count that is NaN': [(m) => { m.blocks[0].count = null; }, /count should be an integer/],
  'half a Gaussian': [(m) => { m.blocks[0].count = 1.5; }, /count should be an integer/],
  'more in a stream than in its block':
    [(m) => { m.blocks[0].streams[0].count = 5; }, /count should be an integer from 0 to 4/],
  'a negative offset': [(m) => { m.blocks[0].streams[0].offset = -1; }, /offset should be/],
  'a stream beyond its block':
    [(m) => { m.blocks[0].streams[0].offset = m.blocks[0].bytes; }, /offset \+ bytes should be/],
  'offset + bytes that overflow':
    [(m) => { m.blocks[0].streams[0].bytes = 2 ** 53; }, /bytes should be an integer/],
  'scales too few': [(m) => { m.blocks[0].streams[3].scale = []; }, /scale should be 1 numbers/],
  'an infinite scale': [(m) => { m.blocks[0].streams[3].scale = [1e999]; }, /scale should be 1/],
  'another server': [(m) => { m.blocks[0].file = 'https://a.b/c'; }, /a file below the manifest/],
  'another server, short': [(m) => { m.blocks[0].file = '//a.b/c'; }, /a file below/],
  'a folder above': [(m) => { m.blocks[0].file = 'x/../../y'; }, /a file below/],
  'a camera without a size':
    [(m) => { m.cameras = [{name: 'a', position: [0, 0, 0], rotation: [1, 0, 0, 0], width: 0,
                            height: 1, fx: 1, fy: 1, cx: 0, cy: 0}]; }, /width should be above 0/],
  'an anchor of its own': [(m) => { m.anchor = 'middle'; }, /anchor should be/],
};

// Bug put back: no upper limit of count, offsets below 0 let through, files of other servers let
// through; each seen to fail.
test('manifests as they should not be', async (t) => {
  for (const [name, [spoil, pattern]] of Object.entries(kManifests))
    await t.test(name, () => {
      const manifest = structuredClone(makeManifest([good()]));
      spoil(manifest);
      assert.throws(() => readManifest(manifest, 'manifest.json'), (e) => refuses(e, pattern));
    });
  await t.test('no JSON', () => assert.throws(() => parseJson('{"format":', 'manifest.json'),
                                              (e) => refuses(e, /no JSON/)));
  readManifest(makeManifest([good()]), 'manifest.json');  // the one that was not spoilt
});

/** Puts other bytes in the place of stream 0, with the right checksum of the whole. */
function withStream(packed, change = {}) {
  const {position, ...rest} = plainStreams(4);
  const block = makeBlock({count: 4, file: 'a.bin', streams: {
    blob: {type: 'u8', rows: [...packed].map((byte) => [byte]), codec: 'none'}, ...rest}});
  block.info.streams[0] = {name: 'position', type: 'f32', components: 3, count: 4, delta: false,
                           codec: 'gzip', offset: 0, bytes: packed.length, ...change};
  return block;
}
const zipped = (bytes) => gzipSync(Buffer.alloc(bytes));

const kBlocks = {
  'gzip that ends early': [() => withStream(zipped(48).subarray(0, -9)), /position.*gzip/],
  'no gzip at all': [() => withStream(Buffer.from('hello, this is no gzip')), /position.*gzip/],
  'gzip with a wrong checksum of its own': [() => {
    const bytes = zipped(48);
    bytes[bytes.length - 6] ^= 1;
    return withStream(bytes);
  }, /position.*gzip/],
  'fewer bytes than the count asks for': [() => withStream(zipped(47)), /47 bytes of the 48/],
  'a bomb': [() => withStream(zipped(1e7)), /more than the 48 bytes/],
  'another codec': [() => withStream(zipped(48), {codec: 'zstd'}), /codec "zstd" is not known/],
  'another type': [() => withStream(zipped(48), {type: 'bf16'}), /type "bf16" is not known/],
  'plain bytes too few': [() => withStream(zipped(48), {codec: 'none'}), /expected 48/],
  'too many components': [() => withStream(zipped(64), {components: 4}), /4 components, expected 3/],
  'no positions': [() => withStream(zipped(48), {name: 'other'}), /0 of 4 Gaussians have position/],
  'positions of some': [() => withStream(zipped(36), {count: 3}), /3 of 4 Gaussians have position/],
  'cut off': [() => { const b = good(); b.bytes = b.bytes.subarray(0, -1); return b; },
              /a\.bin: \d+ bytes of \d+, so it is cut off/],
  'a bit that flipped': [() => { const b = good(); b.bytes[20] ^= 4; return b; }, /checksum differs/],
};

// Bug put back: checkBytes() left away, gunzip() without its limit; each seen to fail.
test('blocks as they should not be', async (t) => {
  for (const [name, [make, pattern]] of Object.entries(kBlocks))
    await t.test(name, () => assert.rejects(decoded(make()), (e) => refuses(e, pattern)));
  assert.equal((await decoded(good())).count, 4);
});

// Bug put back: offsets counted from the beginning of the file; seen to fail.
test('single files', async (t) => {
  const first = makeBlock({count: 2, streams: plainStreams(2)});
  const second = makeBlock({count: 3, offset: first.bytes.length, streams: plainStreams(3)});
  const file = makeSingle(makeManifest([first, second]), [first, second]);
  const open = (bytes) => bytesSource(new Uint8Array(bytes), 'scene.t4d', null);
  const read = async (bytes, i) => {
    const source = open(bytes);
    const block = source.manifest.blocks[i];
    return decodeBlock(block, await source.fetchBlock(block));
  };
  assert.equal((await read(file, 1)).count, 3);
  await t.test('wrong magic', () => assert.throws(
    () => open(Buffer.concat([Buffer.from('PLY4'), file.subarray(4)])), (e) => refuses(e, /TES4/)));
  await t.test('empty', () => assert.throws(() => open([]), (e) => refuses(e, /TES4/)));
  await t.test('a later version', () => {
    const later = Buffer.from(file);
    later.writeUInt32LE(9, 4);
    assert.throws(() => open(later), (e) => refuses(e, /version 9 is later/));
  });
  await t.test('a manifest beyond the end', () => {
    const long = Buffer.from(file);
    long.writeUInt32LE(0xfffffff0, 8);
    assert.throws(() => open(long), (e) => refuses(e, /so it is cut off/));
  });
  await t.test('cut off within a block', () => assert.rejects(
    read(file.subarray(0, -5), 1), (e) => refuses(e, /so it is cut off/)));
  await t.test('a block that is said to be a file', () => {
    const inFolder = makeManifest([good()]);
    assert.throws(() => open(makeSingle(inFolder, [])), (e) => refuses(e, /not in this file/));
  });
});
