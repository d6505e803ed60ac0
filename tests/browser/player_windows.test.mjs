// The player's reader of files of windows (version 3) without a browser: manifests as they should and
// should not be, heads of blocks, time of a window, what is drawn at a border, and what is fetched.
import assert from 'node:assert/strict';
import {setImmediate as turn} from 'node:timers/promises';
import {test} from 'node:test';
import {playerModules} from './player_modules.mjs';
import {makeBlock, makeManifest, makeSingle, movingStreams, plainStreams} from
    './tessera4d_writer.mjs';
import {bytesOf, evenWindows, joinWindows} from './windowed_file.mjs';

const {BlockCache, blockHits, bytesSource, decodeBlock, lightAt, ownTime, packBlock, readManifest,
       singleFileSource} =
    await playerModules('block_hits', 'blocks', 'container', 'manifest', 'packing', 'tessera4d',
                        'windows');

/** A clip of version 1 with eight dynamic blocks, seen in parts of it that overlap. */
function clipOf() {
  const spans = Array.from({length: 8}, (_, k) => [Math.max(0, k / 8 - 0.05), Math.min(1, k / 8 + 0.2)]);
  const moving = spans.map((visible) => makeBlock({kind: 'dynamic', count: 3, visible, file: 'a.bin',
                                                   streams: movingStreams(3)}));
  const entries = [makeBlock({count: 2, file: 'a.bin', streams: plainStreams(2)}), ...moving];
  const manifest = makeManifest(entries, {gaussians: {static: 2, dynamic: 24}});
  return {manifest, entries};
}
const file = (count = 4) => joinWindows(clipOf(), evenWindows(count), 5 * count);
const read = (manifest) => readManifest(structuredClone(manifest), 'scene.t4d');

const kManifests = {
  'no windows': [(m) => { delete m.windows; }, /windows should be a list of at least one/],
  'a gap': [(m) => { m.windows[1].drawn[0] += 0.01; }, /windows\[1\]\.drawn should be a core that begins at 0\.25/],
  'an overlap': [(m) => { m.windows[1].drawn[0] -= 0.01; }, /windows\[1\]\.drawn should be a core/],
  'a late begin': [(m) => { m.windows[0].drawn[0] = 0.1; }, /a core that begins at 0,/],
  'an early end': [(m) => { m.windows[3].drawn[1] = 0.9; }, /windows\[3\]\.drawn should be a core that ends at 1/],
  'an empty core': [(m) => { m.windows[0].drawn = [0, 0]; }, /drawn should be a time and a later one/],
  'time the other way round': [(m) => { m.windows[0].time.reverse(); }, /time should be a time and a later/],
  'a core beyond its time': [(m) => { m.windows[1].time = [0.3, 0.6]; }, /drawn should be within time/],
  'times that are no numbers': [(m) => { m.windows[1].time = ['0', 1]; }, /windows\[1\]\.time should be 2 numbers/],
  'a dynamic block without window': [(m) => { delete m.blocks[1].window; }, /window should be an integer from 0 to 3/],
  'a window that is none': [(m) => { m.blocks[1].window = 4; }, /window should be an integer from 0 to 3/],
  'a static block of a window': [(m) => { m.blocks[0].window = 0; }, /window should be absent from a static/],
  'a canonical block': [(m) => { m.blocks[0].kind = 'canonical'; }, /kind should be static or dynamic/],
  'a block of another time than its window':
    [(m) => { m.blocks[1].visible = [0.8, 0.9]; }, /visible should be within its window/],
  'no head': [(m) => { delete m.blocks[0].head; }, /head should be an integer from 1/],
  'a head beyond its block':
    [(m) => { m.blocks[0].head = m.blocks[0].bytes + 1; }, /head should be an integer from 1/],
  'a light of two colours': [(m) => { m.windows[1].light = [1, 1]; }, /windows\[1\]\.light should be 3 numbers/],
  'no light': [(m) => { m.windows[1].light = [1, 0, 1]; }, /light should be 3 numbers between 0 and 100/],
  'no peak': [(m) => { delete m.gaussians.peak; }, /gaussians\.peak should be/],
};

// Bugs put back: cores not compared with their neighbours; windows of dynamic blocks not asked for;
// each seen to fail.
test('manifests of windows as they should not be', async (t) => {
  for (const [name, [spoil, pattern]] of Object.entries(kManifests))
    await t.test(name, () => {
      const manifest = structuredClone(file().manifest);
      spoil(manifest);
      assert.throws(() => read(manifest), (error) => {
        assert.equal(error.name, 'PlayerError', error.stack);
        assert.match(error.message, /^scene\.t4d: .*; export the scene again$/);
        assert.match(error.message, pattern);
        return true;
      });
    });
  assert.equal(read(file().manifest).windows.length, 4);
});

test('versions 1 and 2 have no windows, whatever further keys they hold', () => {
  const {manifest} = clipOf();
  const {windows} = file().manifest;
  const whole = read({...manifest, windows, blocks: manifest.blocks.map((b) => ({...b, head: 7, window: 1}))});
  assert.deepEqual(whole.windows, []);
  for (const {window, drawn, head, streams} of whole.blocks) {
    assert.deepEqual([window, drawn, head], [null, null, 0]);
    assert.ok(streams.length >= 5);
  }
});

const decodedOf = async (made, i) => {
  const source = bytesSource(new Uint8Array(bytesOf(made)), 'scene.t4d', null);
  const block = source.manifest.blocks[i];
  return decodeBlock(block, await source.fetchBlock(block, {}));
};

// Bug put back: offsets of streams counted from the beginning of the block, so the head is not
// skipped; seen to fail.
test('a block behind its head decodes as the block without one', async () => {
  const clip = clipOf();
  const alone = bytesSource(new Uint8Array(makeSingle(
      makeManifest(clip.entries.map(({info: {file: _, ...info}, bytes}) => ({bytes, info: {...info, offset: 0}}))),
      clip.entries)), 'scene.t4d', null);
  const plain = await decodeBlock(alone.manifest.blocks[0], await alone.fetchBlock(alone.manifest.blocks[0], {}));
  assert.deepEqual(await decodedOf(file(), 0), plain);
  const moving = await decodedOf(file(), 1);
  assert.deepEqual([...moving.timeMean], [0.5, 0.5, 0.5]);
});

/** The file whose block 0 has another head of the same length, with the right checksum. */
function withHead(text) {
  const clip = clipOf();
  const made = joinWindows(clip, evenWindows(2), 10);
  const {info, bytes} = made.blocks[0];
  const head = Buffer.from(text);
  const rest = bytes.subarray(info.head);
  const other = makeBlock({count: info.count, streams: {blob: {
    type: 'u8', codec: 'none', rows: [...head, ...rest].map((byte) => [byte])}}});
  made.blocks[0] = {bytes: other.bytes, info: {...info, head: head.length, bytes: other.bytes.length,
                                               crc32: other.info.crc32}};
  made.manifest.blocks[0] = made.blocks[0].info;
  return made;
}

// Bug put back: lengths of streams not compared with the bytes behind the head; seen to fail.
test('heads as they should not be', async () => {
  const stream = (more) => JSON.stringify({streams: [
    {name: 'position', type: 'f32', components: 3, count: 2, codec: 'none', offset: 0, bytes: 24, ...more}]});
  for (const [text, pattern] of [
    ['{"streams": [', /block 0: its head is no JSON; export/],
    ['[1]', /block 0: .* should be an object/],
    ['{"streams": 7}', /block 0: streams should be a list/],
    ['{}', /0 of 2 Gaussians have position/],
    [stream({offset: 1e6}), /streams\[0\]\.offset should be an integer from 0 to/],
    [stream({bytes: 1e6}), /streams\[0\]\.bytes should be an integer from 0 to/],
    [stream({count: 3}), /streams\[0\]\.count should be an integer from 0 to 2/],
  ])
    await assert.rejects(decodedOf(withHead(text), 0), (error) => {
      assert.equal(error.name, 'PlayerError', error.stack);
      assert.match(error.message, pattern);
      return true;
    });
  const made = withHead(stream());
  const data = made.blocks[0].bytes.length - made.blocks[0].info.head;
  await assert.rejects(decodedOf(withHead(stream({offset: data - 23})), 0), /offset \+ bytes should be at most/);
});

// Bugs put back: a closed interval; the end of the last window left out; each seen to fail.
test('at a border the blocks of one window are drawn, and at the end those of the last', () => {
  const {blocks} = read(file(4).manifest);
  const cache = new BlockCache(blocks, 1e9, {load: () => new Promise(() => {}), release() {}, onChange() {}});
  const windowsAt = (t) => [...new Set(cache.at(t).map((i) => blocks[i].window))];
  assert.deepEqual(windowsAt(0), [null, 0]);
  for (let i = 1; i < 4; ++i) {
    assert.deepEqual(windowsAt(i / 4 - 1e-9), [null, i - 1]);
    assert.deepEqual(windowsAt(i / 4), [null, i]);
  }
  assert.deepEqual(windowsAt(1), [null, 3]);
});

// Bug put back: visible beyond the core taken as it is; seen to fail.
test('visible ends where its window does', () => {
  const {manifest} = file(4);
  const i = manifest.blocks.findIndex(({window}) => window === 1);
  manifest.blocks[i].visible = [0, 1];
  assert.deepEqual(read(manifest).blocks[i].visible, [0.25, 0.5]);
});

// Bugs put back, each seen to fail: the light of the window before; that of a window for all.
test('static Gaussians are in the light of the window that is drawn', () => {
  const {windows} = read(file(4).manifest);
  for (const [t, expected] of [[0, [1, 1, 1]], [0.25, [0.6, 0.8, 1.2]], [0.5 - 1e-9, [0.6, 0.8, 1.2]],
                               [0.5, [1, 1, 1]], [1, [0.6, 0.8, 1.2]]])
    assert.deepEqual(lightAt(windows, t), expected, `t = ${t}`);
  assert.deepEqual(lightAt([], 0.5), [1, 1, 1]);
});

// Bug put back: t in the place of tau; seen to fail.
test('Gaussians of a window are met where tau has them', async () => {
  const windows = [{time: [0, 0.6], drawn: [0, 0.5]}, {time: [0.4, 1], drawn: [0.5, 1]}];
  assert.equal(ownTime(windows, null, 0.7), 0.7);
  assert.ok(Math.abs(ownTime(windows, 1, 0.7) - 0.5) < 1e-12);
  const packed = packBlock(await decodedOf(file(4), 1));
  const ray = (x) => ({origin: {x, y: 0, z: -5}, direction: {x: 0, y: 0, z: 1}});
  // the mean moves one unit along x in a unit of tau, and is at the origin at its half
  const tau = ownTime(windows, 1, 0.52);
  assert.equal(blockHits(packed, ray(tau - 0.5), tau, true).length, 3);
  assert.equal(blockHits(packed, ray(0.52 - 0.5), tau, true).length, 0);
});

/** A cache over the ten-minute file whose every block takes `memory`; most that it held at a time. */
function longCache(memory, budget) {
  const {blocks} = read(file(120).manifest);
  const state = {held: 0, most: 0, asked: 0};
  const cache = new BlockCache(blocks, budget, {
    load: async () => {
      ++state.asked;
      state.most = Math.max(state.most, state.held += memory);
      return {memory};
    },
    release: () => { state.held -= memory; },
    onChange() {},
  });
  const settle = async () => { for (let k = 0; k < 12; ++k) await turn(); };
  return {cache, state, settle};
}

// Bugs put back: blocks that are not needed count against what is fetched ahead, so that a full memory
// fetches none; nothing freed; each seen to fail.
test('memory stays within the budget, and the next window is there before its border', async () => {
  const [memory, budget, ahead] = [10, 100, 2.5 / 600];
  const {cache, state, settle} = longCache(memory, budget);
  let late = 0;
  for (let seconds = 0; seconds < 600; seconds += 0.25) {
    late += Number(seconds > 0 && cache.waiting(seconds / 600));
    cache.update({t: seconds / 600, ahead, loop: true});
    late += Number(seconds > 0 && cache.waiting(seconds / 600));
    await settle();
  }
  assert.equal(late, 0, 'times that had to wait');
  assert.ok(state.most <= budget + 4 * memory, `${state.most}: more than what is on its way`);
  assert.ok(state.held <= budget, `${state.held} at rest`);
  for (let k = 0; k < 500; ++k) {
    cache.update({t: (k * 0.618034) % 1, ahead: 0, loop: true});
    await settle();
    assert.ok(state.held <= budget, `${state.held} after seek ${k}`);
  }
});

/** fetch() of this file's bytes in the place of the global one; what was asked for. */
function served(t, bytes) {
  const original = globalThis.fetch, asked = [];
  t.after(() => { globalThis.fetch = original; });
  globalThis.fetch = async (_, {headers}) => {
    const [first, last] = headers.Range.match(/\d+/g).map(Number);
    asked.push([first, last]);
    return new Response(bytes.subarray(first, last + 1), {status: 206});
  };
  return asked;
}

// Bugs put back: a first read of 64 KiB; blocks that came with the manifest fetched again; each seen to
// fail.
test('one request brings the manifest of ten minutes and the blocks behind it', async (t) => {
  const made = file(120);
  const bytes = bytesOf(made);
  const asked = served(t, bytes);
  const source = await singleFileSource('http://a.b/scene.t4d', {});
  assert.deepEqual(asked, [[0, (1 << 18) - 1]]);
  assert.ok(JSON.stringify(made.manifest).length > 1 << 16, 'more than was read at first before');
  for (const i of [0, 5]) {
    const block = source.manifest.blocks[i];
    assert.deepEqual(Buffer.from(await source.fetchBlock(block, {})), made.blocks[i].bytes);
  }
  assert.equal(asked.length, 1);
  const last = source.manifest.blocks.at(-1);
  assert.deepEqual(Buffer.from(await source.fetchBlock(last, {})), made.blocks.at(-1).bytes);
  assert.equal(asked.length, bytes.length > 1 << 18 ? 2 : 1);
});
