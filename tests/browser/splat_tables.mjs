// Splat files as columns of numbers and the differences between two of them. 3DGS .ply and .glb are
// read from their layouts, all other formats by splat-transform. Source:
// docs/reference/splat-formats.md.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';

import {packagesFolder} from './harness.mjs';

export const splatTransform =
    await import(join(packagesFolder, '@playcanvas/splat-transform/dist/index.mjs'));

/** A file → splat-transform → the bytes of `name`, whose ending says the format. */
export async function transformed(path, name, options = {}) {
  const files = new splatTransform.MemoryReadFileSystem();
  files.set(path, new Uint8Array(readFileSync(path)));
  const [source] = await splatTransform.readFile(
      {filename: path, inputFormat: splatTransform.getInputFormat(path), options: {}, params: [],
       fileSystem: files});
  const written = new splatTransform.MemoryFileSystem();
  await splatTransform.writeSource(
      {filename: name, outputFormat: splatTransform.getOutputFormat(name, {}), source,
       pool: splatTransform.createChunkDataPool(), options},
      written);
  return Buffer.from(written.results.get(name));
}

/** {rows, columns: {name: Float32Array}} of a .ply whose only element has floats alone. */
export function plyColumns(bytes) {
  const mark = 'end_header\n';
  const end = bytes.indexOf(mark) + mark.length;
  const lines = bytes.toString('latin1', 0, end).split('\n');
  const rows = Number(/^element vertex (\d+)$/m.exec(lines.join('\n'))[1]);
  const names = lines.filter((line) => line.startsWith('property')).map((line) => {
    const [, type, name] = line.split(' ');
    assert.equal(type, 'float');
    return name;
  });
  assert.equal(bytes.length, end + 4 * rows * names.length);
  const columns = Object.fromEntries(names.map((name) => [name, new Float32Array(rows)]));
  for (let row = 0, place = end; row < rows; ++row)
    for (const name of names) {
      columns[name][row] = bytes.readFloatLE(place);
      place += 4;
    }
  return {rows, columns};
}

/** Attributes of the only primitive of a .glb: {count, attributes: {name: [numbers]}, splatting}. */
export function glbAttributes(bytes) {
  assert.equal(bytes.toString('latin1', 0, 4), 'glTF');
  const textBytes = bytes.readUInt32LE(12), start = 20 + textBytes + 8;
  const document = JSON.parse(bytes.toString('utf8', 20, 20 + textBytes));
  const primitive = document.meshes[0].primitives[0], attributes = {};
  for (const [name, index] of Object.entries(primitive.attributes)) {
    const accessor = document.accessors[index], view = document.bufferViews[accessor.bufferView];
    const width = {SCALAR: 1, VEC3: 3, VEC4: 4}[accessor.type];
    const place = start + (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    const read = {5126: (i) => bytes.readFloatLE(place + 4 * i), 5121: (i) => bytes[place + i] / 255};
    assert.ok(!view.byteStride || accessor.componentType === 5126, 'packed columns');
    attributes[name] = Array.from({length: width * accessor.count}, (_, i) =>
        read[accessor.componentType](i));
  }
  return {count: document.accessors[primitive.attributes.POSITION].count, attributes,
          splatting: primitive.extensions.KHR_gaussian_splatting};
}

/** Chunks of 256 of a compressed .ply: {min, max} by x, y, z, scale_x, …, r, g, b. */
export function chunkRanges(bytes) {
  const mark = 'end_header\n', end = bytes.indexOf(mark) + mark.length;
  const header = bytes.toString('latin1', 0, end);
  const count = Number(/element chunk (\d+)/.exec(header)[1]);
  const names = header.split('element vertex')[0].match(/(?<=property float )\w+/g);
  return Array.from({length: count}, (_, chunk) => {
    const range = {};
    names.forEach((name, k) => range[name] = bytes.readFloatLE(end + 4 * (18 * chunk + k)));
    return range;
  });
}

/** For each row of a the row of b whose mean is nearest; every row of b is taken once. */
export function matchedRows(a, b) {
  assert.equal(b.rows, a.rows, 'as many splats');
  const p = a.columns, q = b.columns, rows = [];
  for (let i = 0; i < a.rows; ++i) {
    let best = -1, least = Infinity;
    for (let j = 0; j < b.rows; ++j) {
      const distance = (p.x[i] - q.x[j]) ** 2 + (p.y[i] - q.y[j]) ** 2 + (p.z[i] - q.z[j]) ** 2;
      if (distance < least) least = distance, best = j;
    }
    rows.push(best);
  }
  assert.equal(new Set(rows).size, a.rows, 'no splat twice');
  return rows;
}

const alpha = (logit) => 1 / (1 + Math.exp(-logit));

/** Of two quaternions w, x, y, z, of which q and −q are the same; both of length 1 afterwards. */
function turn(p, q) {
  const unit = (v) => v.map((x) => x / Math.hypot(...v));
  const [a, b] = [unit(p), unit(q)];
  return Math.min(Math.hypot(...a.map((x, k) => x - b[k])), Math.hypot(...a.map((x, k) => x + b[k])));
}

/**
 * The largest share of what each quantity may be off by: ≤ 1 means within its bound. `bounds(row)`
 * → {position: [3], log_scale: [3], opacity, colour: [3] (f_dc), rotation, sh: (coefficient) → …}
 * of a row of b. Quantities without a bound are not looked at.
 */
export function worstShares(a, b, rows, bounds) {
  const worst = {};
  const note = (what, difference, bound) => {
    worst[what] = Math.max(worst[what] ?? 0, bound === 0 && difference === 0 ? 0 : difference / bound);
  };
  const rest = Object.keys(a.columns).filter((name) => name.startsWith('f_rest')).length;
  rows.forEach((j, i) => {
    const bound = bounds(j), off = (name) => Math.abs(a.columns[name][i] - b.columns[name][j]);
    ['x', 'y', 'z'].forEach((name, k) => note('position', off(name), bound.position[k]));
    for (let k = 0; k < 3; ++k) {
      note('log_scale', off(`scale_${k}`), bound.log_scale[k]);
      note('colour', off(`f_dc_${k}`), bound.colour[k]);
    }
    note('opacity', Math.abs(alpha(a.columns.opacity[i]) - alpha(b.columns.opacity[j])),
         bound.opacity);
    const q = (table, row) => [0, 1, 2, 3].map((k) => table.columns[`rot_${k}`][row]);
    note('rotation', turn(q(a, i), q(b, j)), bound.rotation);
    for (let k = 0; bound.sh && k < rest; ++k)
      note('sh', off(`f_rest_${k}`), bound.sh(k % (rest / 3)));
  });
  return worst;
}
