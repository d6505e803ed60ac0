// Readers of 4D splat files by the text of their specifications: times and velocities are decoded
// here, and what .sogst and .tsog share with .sog by splat-transform. Each gives the columns of a
// 3DGS .ply at a time. Source: "FTGS PLY, version 1"; "The .sogst format", revision 14; "TSOG
// Playback Profile 1", 1.0.1.
import {readFileSync} from 'node:fs';

import {plyColumns, splatTransform} from './splat_tables.mjs';

/** {name: bytes} of a zip archive of stored entries. */
function zipEntries(bytes) {
  const entries = {};
  let place = bytes.readUInt32LE(bytes.length - 6);  // of the central directory
  for (let left = bytes.readUInt16LE(bytes.length - 12); left > 0; --left) {
    const [size, name, extra, comment] =
        [bytes.readUInt32LE(place + 24), ...[28, 30, 32].map((k) => bytes.readUInt16LE(place + k))];
    const local = bytes.readUInt32LE(place + 42);
    const start = local + 30 + bytes.readUInt16LE(local + 26) + bytes.readUInt16LE(local + 28);
    entries[bytes.toString('utf8', place + 46, place + 46 + name)] =
        bytes.subarray(start, start + size);
    place += 46 + name + extra + comment;
  }
  return entries;
}

/** The columns of a .ply of an archive's static attributes: it is given out as version 2 of .sog. */
async function staticColumns(entries, meta) {
  const files = new splatTransform.MemoryReadFileSystem();
  for (const [name, bytes] of Object.entries(entries)) files.set(name, new Uint8Array(bytes));
  files.set('meta.json', new TextEncoder().encode(JSON.stringify({...meta, version: 2})));
  const [source] = await splatTransform.readFile(
      {filename: 'meta.json', inputFormat: 'sog', options: {}, params: [], fileSystem: files});
  const written = new splatTransform.MemoryFileSystem();
  await splatTransform.writeSource({filename: 'a.ply', outputFormat: 'ply', source, options: {},
                                    pool: splatTransform.createChunkDataPool()}, written);
  return plyColumns(Buffer.from(written.results.get('a.ply'))).columns;
}

/** Line by line {x, v, time, sigma} of one clock, and the static columns. */
async function archiveLines(bytes) {
  const entries = zipEntries(bytes), meta = JSON.parse(entries['meta.json'].toString());
  const columns = await staticColumns(entries, meta);
  const codec = await splatTransform.WebPCodec.create();
  const pixels = (name) => codec.decodeRGBA(new Uint8Array(entries[name])).rgba;
  const plane = ([low, high], mins, maxs) => {
    const [a, b] = [pixels(low), pixels(high)];
    return (i, k) => mins[k] + (a[4 * i + k] + 256 * b[4 * i + k]) / 65535 * (maxs[k] - mins[k]);
  };
  const unlog = (x) => Math.sign(x) * Math.expm1(Math.abs(x));
  if (meta.format === 'sogst') {
    const velocity = plane(meta.motion.files, meta.motion.mins, meta.motion.maxs);
    const trbf = pixels(meta.trbf.files[0]);
    return {columns, clock: (t) => meta.time.min + t * (meta.time.max - meta.time.min),
            line: (i) => ({v: [0, 1, 2].map((k) => unlog(velocity(i, k))),
                           time: meta.trbf.center.codebook[trbf[4 * i]],
                           sigma: meta.trbf.sigma.codebook[trbf[4 * i + 1]]})};
  }
  const {files, mins, maxs} = meta.temporal.means;
  const velocity = plane(files, mins[0], maxs[0]);
  const life = plane(meta.timeline.files, meta.timeline.mins, meta.timeline.maxs);
  return {columns, clock: (t) => t,
          line: (i) => ({v: [0, 1, 2].map((k) => velocity(i, k)), time: life(i, 0),
                         sigma: life(i, 1)})};
}

function plyLines(bytes) {
  const {columns} = plyColumns(bytes);
  const comment = (key) => Number(new RegExp(`^comment ${key} (.*)$`, 'm').exec(
      bytes.toString('latin1', 0, 4096))?.[1]);
  if ('log_duration' in columns)
    return {columns, clock: (t) => t,
            line: (i) => ({v: [0, 1, 2].map((k) => columns[`velocity_${k}`][i]),
                           time: columns.time[i],
                           sigma: Math.max(Math.exp(columns.log_duration[i]),
                                           comment('min_duration'))})};
  const [min, max] = [comment('sogst.time_min'), comment('sogst.time_max')];
  return {columns, clock: (t) => min + t * (max - min),
          line: (i) => ({v: ['vx', 'vy', 'vz'].map((name) => columns[name][i]),
                         time: columns.t_center[i], sigma: columns.t_sigma[i]})};
}

/** A file → a function of normalised time → the bytes of a 3DGS .ply at that time. */
export async function lineFile(path) {
  const bytes = readFileSync(path);
  const {columns, clock, line} =
      bytes.toString('latin1', 0, 3) === 'ply' ? plyLines(bytes) : await archiveLines(bytes);
  const rest = Object.keys(columns).filter((name) => name.startsWith('f_rest_')).length;
  const names = ['x', 'y', 'z', 'f_dc_0', 'f_dc_1', 'f_dc_2',
                 ...Array.from({length: rest}, (_, k) => `f_rest_${k}`), 'opacity', 'scale_0',
                 'scale_1', 'scale_2', 'rot_0', 'rot_1', 'rot_2', 'rot_3'];
  const rows = columns.x.length;
  return (t) => {
    const now = clock(t), body = Buffer.alloc(4 * rows * names.length);
    for (let i = 0; i < rows; ++i) {
      const {v, time, sigma} = line(i), dt = now - time;
      const opacity = Math.exp(-0.5 * (dt / sigma) ** 2) / (1 + Math.exp(-columns.opacity[i]));
      const moved = {x: columns.x[i] + v[0] * dt, y: columns.y[i] + v[1] * dt,
                     z: columns.z[i] + v[2] * dt,
                     opacity: Math.log(Math.max(opacity, 1e-9) / Math.max(1 - opacity, 1e-9))};
      names.forEach((name, k) =>
          body.writeFloatLE(moved[name] ?? columns[name][i], 4 * (i * names.length + k)));
    }
    const header = ['ply', 'format binary_little_endian 1.0', `element vertex ${rows}`,
                    ...names.map((name) => `property float ${name}`), 'end_header', ''];
    return Buffer.concat([Buffer.from(header.join('\n')), body]);
  };
}
