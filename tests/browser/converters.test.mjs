// Files of Tessera through splat-transform and files of splat-transform through Tessera, compared
// number by number within the quantum of each format. Source: docs/reference/splat-formats.md.
import assert from 'node:assert/strict';
import {readdirSync, readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {before, test} from 'node:test';

import {fixture, scratchFolder, tessera} from './harness.mjs';
import {chunkRanges, glbAttributes, matchedRows, plyColumns, transformed, worstShares}
  from './splat_tables.mjs';

const folder = scratchFolder();
const kSh0 = 0.28209479177387814;
const kHalfByte = 0.5 / 255 + 1e-6;
const kTenBits = 0.0025;  // four parts, the largest from three that are off by √½/1022

/** The file of one exported timestep. */
function exported(model, format, extension, ...more) {
  const out = join(folder, `${format}${more.join('')}${exported.count++}`);
  tessera('export', model, '--format', format, '-o', out, ...more);
  return join(out, `frame_0000${extension}`);
}
exported.count = 0;

let plyPath, ply;
before(() => {
  plyPath = exported(fixture.model, 'ply', '.ply', '--time', 0.5);
  ply = plyColumns(readFileSync(plyPath));
  assert.ok(ply.rows > 1400 && ply.rows < 2200, `${ply.rows}`);
  const rest = ply.columns.f_rest_44;
  assert.ok(rest.some((x) => x !== 0), 'view-dependent colours to be compared');
});

/** Asserts that every quantity is within its bound, and not trivially so. */
function expectWithin(a, b, bounds) {
  const worst = worstShares(a, b, matchedRows(a, b), bounds);
  for (const [what, share] of Object.entries(worst))
    assert.ok(share <= 1, `${what}: ${share.toFixed(3)} of its bound`);
  return worst;
}

/** Signs of SH from degree 1 on where y and z change theirs. */
const kTurnedSh = [-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1];

/** Half a turn about x: splat-transform takes .spz as it is stored, without that of its world. */
function turnedAboutX({rows, columns}) {
  const sign = (name) => {
    if (['y', 'z', 'rot_2', 'rot_3'].includes(name)) return -1;
    return name.startsWith('f_rest_') ? kTurnedSh[Number(name.slice(7)) % 15] : 1;
  };
  return {rows, columns: Object.fromEntries(Object.entries(columns).map(
      ([name, values]) => [name, values.map((x) => sign(name) * x)]))};
}

function spzBounds() {
  return {
    position: Array(3).fill(0.5 / 4096 + 1e-6), log_scale: Array(3).fill(0.5 / 16 + 1e-6),
    opacity: kHalfByte, colour: Array(3).fill(0.5 / (255 * 0.15) + 1e-6), rotation: kTenBits,
    // rounded to 1/128, then to the middle of 8 (first degree) or 16 of these
    sh: (k) => (k < 3 ? 4.5 : 8.5) / 128 + 1e-6,
  };
}

/** By the ranges of the chunk that a row of the compressed file lies in. */
function compressedBounds(path) {
  const chunks = chunkRanges(readFileSync(path));
  const part = (range, name, steps) =>
      0.5 * (range[`max_${name}`] - range[`min_${name}`]) / steps * 1.001 + 1e-5;
  return (row) => {
    const range = chunks[Math.floor(row / 256)];
    return {
      position: [part(range, 'x', 2047), part(range, 'y', 1023), part(range, 'z', 2047)],
      log_scale: [part(range, 'scale_x', 2047), part(range, 'scale_y', 1023),
                  part(range, 'scale_z', 2047)],
      opacity: kHalfByte, rotation: kTenBits,
      colour: ['r', 'g', 'b'].map((c) => part(range, c, 255) / kSh0), sh: () => 0.5 / 32 + 1e-6,
    };
  };
}

test('ply: splat-transform writes the same numbers', async () => {
  const theirs = plyColumns(await transformed(plyPath, 'a.ply'));
  const names = Object.keys(ply.columns).sort();
  assert.deepEqual(Object.keys(theirs.columns).sort(), names);
  for (const name of names) assert.deepEqual(theirs.columns[name], ply.columns[name], name);
});

test('ply: read back and written again, the same bytes', () => {
  assert.ok(readFileSync(exported(plyPath, 'ply', '.ply')).equals(readFileSync(plyPath)));
});

// Bugs put back: the quaternion as x, y, z, w; SH by coefficient instead of by channel. Seen to fail.
test('compressed: ours by splat-transform', async () => {
  const path = exported(fixture.model, 'compressed', '.compressed.ply', '--time', 0.5);
  expectWithin(ply, plyColumns(await transformed(path, 'a.ply')), compressedBounds(path));
});

// Bugs put back: axes not flipped; SH of the first degree not flipped; the rotation's largest part
// counted from w. Seen to fail.
for (const version of [3, 4])
  test(`spz ${version}: ours by splat-transform`, async () => {
    const path = exported(fixture.model, 'spz', '.spz', '--time', 0.5, '--spz-version', version);
    const head = readFileSync(path).toString('latin1', 0, 4);
    assert.equal(head === 'NGSP', version === 4);
    expectWithin(ply, turnedAboutX(plyColumns(await transformed(path, 'a.ply'))), spzBounds);
  });

/** meta.json of an archive of stored entries. */
function sogMeta(bytes) {
  const start = bytes.indexOf('{"version"');
  const size = bytes.readUInt32LE(22);  // of meta.json, the first entry
  return JSON.parse(bytes.toString('utf8', start, start + size));
}

/** Half of the widest step of a codebook, which no value of its range is further from. */
const halfGap = (codebook) =>
    Math.max(...codebook.slice(1).map((x, i) => (x - codebook[i]) / 2)) + 1e-5;

function sogBounds(path, table) {
  const meta = sogMeta(readFileSync(path)), {mins, maxs} = meta.means;
  return (row) => ({
    position: ['x', 'y', 'z'].map((name, k) =>
        (0.5 * (maxs[k] - mins[k]) / 65535 + 1e-7) * (1.001 + Math.abs(table.columns[name][row]))),
    log_scale: Array(3).fill(halfGap(meta.scales.codebook)),
    colour: Array(3).fill(halfGap(meta.sh0.codebook)),
    opacity: 2 * kHalfByte, rotation: 0.0097,
  });
}

// SH have a palette of half of the splats: their mean error is compared, not the worst.
test('sog: ours by splat-transform', async () => {
  const path = exported(fixture.model, 'sog', '.sog', '--time', 0.5);
  const theirs = plyColumns(await transformed(path, 'a.ply'));
  expectWithin(ply, theirs, sogBounds(path, theirs));
  const rows = matchedRows(ply, theirs);
  let error = 0, energy = 0;
  for (let k = 0; k < 45; ++k) {
    const a = ply.columns[`f_rest_${k}`], b = theirs.columns[`f_rest_${k}`];
    rows.forEach((j, i) => (error += (a[i] - b[j]) ** 2, energy += a[i] ** 2));
  }
  assert.ok(error < 0.1 * energy, `${error / energy} of the energy of SH is lost`);
});

// Bug put back: the mark left out of compressed files. Seen to fail.
test('antialiased: splat-transform reads the mark of each format that has one', async () => {
  const bytes = readFileSync(plyPath), marked = join(folder, 'marked.ply');
  const mark = 'comment SplatRenderMode: mip\n', place = bytes.indexOf('element vertex');
  writeFileSync(marked, Buffer.concat([bytes.subarray(0, place), Buffer.from(mark),
                                       bytes.subarray(place)]));
  for (const [format, extension] of
       [['ply', '.ply'], ['compressed', '.compressed.ply'], ['spz', '.spz'], ['sog', '.sog']])
    for (const [model, expected] of [[marked, true], [plyPath, false]]) {
      const theirs = await transformed(exported(model, format, extension), 'a.ply');
      assert.equal(theirs.includes(mark), expected, format);
    }
});

// Bug put back: opacity not scaled by 255. Seen to fail.
test('splat: ours by splat-transform', async () => {
  const path = exported(fixture.model, 'splat', '.splat', '--time', 0.5);
  expectWithin(ply, plyColumns(await transformed(path, 'a.ply')), () => ({
    position: [0, 0, 0], log_scale: Array(3).fill(1e-5), opacity: kHalfByte,
    colour: Array(3).fill(kHalfByte / kSh0), rotation: 0.014,  // 1/256 a part, 1/128 at +1
  }));
});

/** xx, xy, xz, yy, yz, zz of the covariance of one splat: quaternion x, y, z, w and scales. */
function covariance(attributes, i) {
  const name = 'KHR_gaussian_splatting';
  const [x, y, z, w] = attributes[`${name}:ROTATION`].slice(4 * i, 4 * i + 4);
  const s = attributes[`${name}:SCALE`].slice(3 * i, 3 * i + 3);
  const R = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
  return [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]].map(
      ([a, b]) => s.reduce((sum, sk, k) => sum + R[a][k] * R[b][k] * sk * sk, 0));
}

// splat-transform does not read .glb: it writes one of the same .ply, and both are compared. It turns
// quaternions with the world where we turn their axes too: the ellipsoids must be equal.
// Bugs put back: w first in ROTATION; axes not flipped. Seen to fail.
test('glb: the same columns as splat-transform writes', async () => {
  const path = exported(fixture.model, 'glb', '.glb', '--time', 0.5);
  const ours = glbAttributes(readFileSync(path));
  const theirs = glbAttributes(await transformed(plyPath, 'a.glb'));
  assert.equal(ours.count, theirs.count);
  const names = Object.keys(theirs.attributes);
  assert.ok(names.includes('KHR_gaussian_splatting:SH_DEGREE_3_COEF_6'), `${names}`);
  for (let i = 0; i < ours.count; ++i) {
    const a = covariance(ours.attributes, i), b = covariance(theirs.attributes, i);
    const size = b[0] + b[3] + b[5];
    b.forEach((x, k) => assert.ok(Math.abs(a[k] - x) < 1e-5 * size, `covariance ${i}: ${a}, ${b}`));
  }
  for (const name of names.filter((n) => !n.endsWith(':ROTATION'))) {
    const a = ours.attributes[name], b = theirs.attributes[name];
    assert.equal(a?.length, b.length, name);
    const quantum = name === 'COLOR_0' ? 1.001 / 255 : 0;
    b.forEach((x, i) => assert.ok(Math.abs(a[i] - x) <= quantum + 2e-6 * Math.abs(x),
                                  `${name}[${i}]: ${a[i]}, theirs ${x}`));
  }
});

test('compressed: of splat-transform by us', async () => {
  const path = join(folder, 'theirs.compressed.ply');
  writeFileSync(path, await transformed(plyPath, path));
  const read = plyColumns(readFileSync(exported(path, 'ply', '.ply')));
  expectWithin(ply, read, compressedBounds(path));
});

for (const spzVersion of [3, 4])
  test(`spz ${spzVersion}: of splat-transform by us`, async () => {
    const path = join(folder, `theirs_${spzVersion}.spz`);
    writeFileSync(path, await transformed(plyPath, path, {spzVersion}));
    const read = plyColumns(readFileSync(exported(path, 'ply', '.ply')));
    expectWithin(turnedAboutX(ply), read, spzBounds);
  });

// The names by which SuperSplat 2.32.2 takes files dropped on it for one sequence.
// Bug put back: five digits from the tenth frame on. Seen to fail.
test('sequences: names that SuperSplat takes for frames, in order, and no other such name', () => {
  const sequence = /(.*?)(\d+)(?:\.compressed)?\.ply$/;
  for (const format of ['ply', 'compressed']) {
    const out = join(folder, `sequence_${format}`);
    tessera('export', fixture.model, '--format', format, '--frames', 12, '-o', out);
    const frames = readdirSync(out).map((name) => sequence.exec(name)).filter((match) => match);
    assert.equal(frames.length, 12);
    assert.deepEqual(new Set(frames.map((match) => match[1])), new Set(['frame_']));
    assert.deepEqual(frames.map((match) => match[0]).sort(),
                     frames.sort((a, b) => a[2] - b[2]).map((match) => match[0]), 'order by name');
  }
});
