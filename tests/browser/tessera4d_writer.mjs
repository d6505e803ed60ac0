// A small writer of Tessera 4D files, made from docs/reference/tessera4d.md alone and independent
// of the program's writer, for invalid files. It neither orders Gaussians nor writes levels of
// detail.
import zlib from 'node:zlib';

const kWidth = {u8: 1, u16: 2, u24: 3, u32: 4, f32: 4};

/** CRC-32 where this Node's zlib has none. */
export function checksum(bytes) {
  if (zlib.crc32) return zlib.crc32(bytes);
  let c = ~0;
  for (const byte of bytes) {
    c ^= byte;
    for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  }
  return ~c >>> 0;
}

/** Planes of integers [Gaussian][component], with differences where `delta`. */
export function planes(rows, {type, components, delta}) {
  const width = kWidth[type] ?? 1, modulus = 2 ** (8 * width);
  const bytes = Buffer.alloc(rows.length * components * width);
  for (let c = 0; c < components; ++c) {
    let last = 0;
    rows.forEach((row, i) => {
      let value = row[c];
      if (delta) {
        let d = (row[c] - last + modulus) % modulus;  // 0 … modulus − 1
        if (d >= modulus / 2) d -= modulus;
        last = row[c];
        value = d >= 0 ? 2 * d : -2 * d - 1;
      }
      for (let b = 0; b < width; ++b)
        bytes[(c * width + b) * rows.length + i] = Math.floor(value / 2 ** (8 * b)) % 256;
    });
  }
  return bytes;
}

export function floatRows(rows) {
  return rows.map((row) => row.map((value) => {
    const view = new DataView(new ArrayBuffer(4));
    view.setFloat32(0, value);
    return view.getUint32(0);
  }));
}

/**
 * A block of streams {name: {type, rows, scale, bias, delta, codec}}; `rows`: integers, or floats of
 * type f32. `more`: further keys. Returns {bytes, info: its entry in the manifest}.
 */
export function makeBlock({kind = 'static', count, visible = [0, 1], file, offset, streams,
                           ...more}) {
  const parts = [], infos = [];
  let place = 0;
  for (const [name, stream] of Object.entries(streams)) {
    const components = stream.components ?? stream.rows[0].length;
    const rows = stream.type === 'f32' ? floatRows(stream.rows) : stream.rows;
    const plain = planes(rows, {...stream, components});
    const codec = stream.codec ?? 'gzip';
    const bytes = codec === 'gzip' ? zlib.gzipSync(plain) : plain;
    const scaled = /^u\d/.test(stream.type) && {
      scale: stream.scale ?? Array(components).fill(1), bias: stream.bias ?? Array(components).fill(0)};
    infos.push({name, type: stream.type, components, count: rows.length, codec, ...scaled,
                delta: stream.delta ?? false, offset: place, bytes: bytes.length});
    parts.push(bytes);
    place += bytes.length;
  }
  const bytes = Buffer.concat(parts);
  const where = file === undefined ? {offset: offset ?? 0} : {file};
  return {bytes, info: {kind, ...where, bytes: bytes.length, crc32: checksum(bytes), visible,
                        level: 0, segment: visible, count, ...more, streams: infos}};
}

export function makeManifest(blocks, more = {}) {
  return {format: 'tessera-4d', version: 1, generator: 'test', axes: 'RDF', up: [0, -1, 0],
          time: {origin: 0, duration: 1, fps: 25}, bounds: {min: [-1, -1, -1], max: [1, 1, 1]},
          gaussians: {static: 0, dynamic: 0}, sh_degree: 0, background: [0, 0, 0],
          splat: {dilation: 0.3, compensated: false, cutoff_sigma: 3.329, cutoff_alpha: 0.00392},
          anchor: 'clip', lossless: false, dropped: {non_finite: 0, never_drawn: 0},
          far_outliers: 0, cameras: [], blocks: blocks.map(({info}) => info), ...more};
}

/** The single file. */
export function makeSingle(manifest, blocks) {
  const json = Buffer.from(JSON.stringify(manifest));
  const head = Buffer.alloc(12);
  head.write('TES4', 'latin1');
  head.writeUInt32LE(1, 4);
  head.writeUInt32LE(json.length, 8);
  return Buffer.concat([head, json, ...blocks.map(({bytes}) => bytes)]);
}

/** A static block of `count` equal Gaussians at the origin. */
export function plainStreams(count) {
  const each = (row) => Array.from({length: count}, () => row);
  return {
    position: {type: 'f32', rows: each([0, 0, 0])},
    rotation: {type: 'f32', rows: each([1, 0, 0, 0])},
    log_scale: {type: 'f32', rows: each([-2, -2, -2])},
    opacity: {type: 'u8', rows: each([255]), scale: [1 / 255]},
    colour: {type: 'f32', rows: each([1, 0, -1])},
  };
}

export function movingStreams(count) {
  const each = (row) => Array.from({length: count}, () => row);
  return {
    ...plainStreams(count),
    velocity: {type: 'f32', rows: each([1, 0, 0])},
    time_mean: {type: 'f32', rows: each([0.5])},
    log_time_scale: {type: 'f32', rows: each([-1])},
  };
}

/** Gaussians carried by one node of two that does nothing. */
export function carriedStreams(count) {
  const each = (row) => Array.from({length: count}, () => row);
  const controls = (row) => Array.from({length: 8}, () => row);  // of two nodes, four each
  return {
    ...plainStreams(count),
    node: {type: 'u8', rows: each([2, 0, 0, 0, 0, 0, 0, 0]), bias: Array(8).fill(-1)},
    node_weight: {type: 'u16', rows: each(Array(7).fill(0)), scale: Array(7).fill(1 / 1023)},
    node_position: {type: 'f32', rows: [[0, 0, 0], [1, 0, 0]]},
    node_translation: {type: 'f32', rows: controls([0, 0, 0])},
    node_rotation: {type: 'f32', rows: controls([1, 0, 0, 0])},
  };
}
