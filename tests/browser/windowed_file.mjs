// A small maker of Tessera 4D files of version 3, independent of the program's writer: windows of a
// long clip, joined of the blocks of files of version 1. Each window can be tinted, so that a test
// sees in an image which window is drawn.
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import zlib from 'node:zlib';
import {checksum} from './tessera4d_writer.mjs';

/** A folder of version 1: its manifest, and `entries` with their bytes. */
export function readFolder(folder) {
  const manifest = JSON.parse(readFileSync(join(folder, 'manifest.json')));
  const entries = manifest.blocks.map(
      (info) => ({info, bytes: readFileSync(join(folder, info.file))}));
  return {manifest, entries};
}

/** Streams whose colours are `tint` brighter, in SH of degree 0. */
function tinted(streams, tint) {
  return streams.map((stream) => {
    if (stream.name !== 'colour' || !tint || !stream.bias) return stream;
    return {...stream, bias: stream.bias.map((value, c) => value + tint[c])};
  });
}

/** Streams whose colours, 0.5 + Y_0 c + …, are those of `streams` times a light. */
function lit(streams, light) {
  const grey = 0.5 / 0.28209479177387814;
  const times = (values, offset) => values.map((v, k) => (v + offset) * light[k % 3] - offset);
  return streams.map((stream) => {
    const offset = stream.name === 'colour' ? grey : 0;
    if (!light || !(offset || /^sh\d$/.test(stream.name))) return stream;
    return {...stream, bias: times(stream.bias, offset), scale: times(stream.scale, 0)};
  });
}

/** The block with its head, and its entry. */
function withHead({info, bytes}, tint, more) {
  const head = Buffer.from(JSON.stringify({streams: tinted(info.streams, tint)}));
  const whole = Buffer.concat([head, bytes]);
  return {bytes: whole, info: {kind: info.kind, bytes: whole.length, crc32: checksum(whole),
                               count: info.count, head: head.length, ...more}};
}

/** The dynamic blocks of a clip as those of window i; those that its core does not reach are left out. */
function blocksOfWindow({entries}, {time: [lo, hi], drawn, tint}, i) {
  const blocks = [];
  for (const entry of entries.filter(({info}) => info.kind === 'dynamic')) {
    const [from, to] = entry.info.visible.map((tau) => lo + tau * (hi - lo));
    const visible = [Math.max(from, drawn[0]), Math.min(to, drawn[1])];
    if (visible[0] < visible[1]) blocks.push(withHead(entry, tint, {visible, window: i}));
  }
  return blocks;
}

/**
 * A file of `windows` [{time, drawn, tint, light}], each of which plays `clip` (of readFolder) in its own
 * time, over the static blocks of the clip. Returns {manifest, blocks} whose offsets are set.
 */
export function joinWindows(clip, windows, seconds) {
  const still = clip.entries.filter(({info}) => info.kind === 'static')
                    .map((entry) => withHead(entry, null, {visible: [0, 1]}));
  const blocks = [...still, ...windows.flatMap((window, i) => blocksOfWindow(clip, window, i))];
  let offset = 0;
  for (const {info, bytes} of blocks) {
    info.offset = offset;
    offset += bytes.length;
  }
  const {dynamic, ...rest} = clip.manifest.gaussians;
  const manifest = {
    ...clip.manifest, version: 3, time: {origin: 0, duration: seconds, fps: 25},
    windows: windows.map(({time, drawn, light}) => ({time, drawn, light})),
    gaussians: {...rest, dynamic: dynamic * windows.length, peak: rest.static + dynamic},
    blocks: blocks.map(({info}) => info),
  };
  return {manifest, blocks};
}

/** `count` windows of `length` seconds, trained on `overlap` seconds more at both ends; all tints differ. */
export function evenWindows(count, length = 5, overlap = 0.5) {
  const seconds = count * length;
  return Array.from({length: count}, (_, i) => ({
    time: [Math.max(0, i * length - overlap) / seconds,
           Math.min(seconds, (i + 1) * length + overlap) / seconds],
    drawn: [i / count, (i + 1) / count],
    light: i % 2 ? [0.6, 0.8, 1.2] : undefined,
    tint: [0, 1, 2].map((c) => Math.cos(2 * Math.PI * (c / 3 + i * 0.618034))),
  }));
}

export function bytesOf({manifest, blocks}) {
  const json = Buffer.from(JSON.stringify(manifest));
  const head = Buffer.alloc(12);
  head.write('TES4', 'latin1');
  head.writeUInt32LE(manifest.version, 4);
  head.writeUInt32LE(json.length, 8);
  return Buffer.concat([head, json, ...blocks.map(({bytes}) => bytes)]);
}

/** The same as a folder. */
export function writeFolder({manifest, blocks}, folder) {
  const infos = blocks.map(({info: {offset, ...info}, bytes}, i) => {
    const file = `block${i}.bin`;
    writeFileSync(join(folder, file), bytes);
    return {...info, file};
  });
  writeFileSync(join(folder, 'manifest.json'), JSON.stringify({...manifest, blocks: infos}));
}

/** Window `window` alone as a single file of version 1, tinted alike: t is the window's tau. */
export function windowAlone(clip, {tint, light}) {
  let offset = 0;
  const blocks = clip.entries.map(({info: {file, ...info}, bytes}) => {
    const streams = info.kind === 'dynamic' ? tinted(info.streams, tint) : lit(info.streams, light);
    const place = offset;
    offset += bytes.length;
    return {bytes, info: {...info, offset: place, streams}};
  });
  return bytesOf({manifest: {...clip.manifest, blocks: blocks.map(({info}) => info)}, blocks});
}

/** A block of `count` Gaussians of no opacity: much memory, few bytes. `kind`: of its entry. */
export function heavyEntry(count, kind = 'dynamic', visible = [0, 1]) {
  const parts = [];
  let offset = 0;
  const stream = (name, components) => {
    const bytes = zlib.gzipSync(Buffer.alloc(count * components));
    parts.push(bytes);
    const each = (value) => Array(components).fill(value);
    const entry = {name, type: 'u8', components, count, delta: false, codec: 'gzip', offset,
                   scale: each(1), bias: each(name === 'rotation' ? 0.5 : 0), bytes: bytes.length};
    offset += bytes.length;
    return entry;
  };
  const streams = [stream('position', 3), stream('rotation', 4), stream('log_scale', 3),
                   stream('opacity', 1), stream('colour', 3), stream('velocity', 3),
                   stream('time_mean', 1), stream('log_time_scale', 1)];
  return {info: {kind, count, visible, streams}, bytes: Buffer.concat(parts)};
}
