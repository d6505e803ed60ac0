// Decodes the streams of a block to floats: codec, planes, differences, scale and bias. Lengths are
// checked, so that no file causes a read or an allocation beyond its data. Source:
// docs/reference/tessera4d.md, section 4.
import { nodeRows, type Block, type Stream } from "./manifest_blocks";
import { PlayerError } from "./player_error";

const BYTES_OF: Record<string, number> = { u8: 1, u16: 2, u24: 3, u32: 4, f32: 4 };

/** One gzip member that must hold exactly `size` bytes; stops as soon as it holds more. */
async function gunzip(packed: Uint8Array, size: number, where: string): Promise<Uint8Array> {
  const out = new Uint8Array(size);
  const damaged = (what: string) =>
    new PlayerError(`${where}: ${what}, so it is damaged; export the scene again`);
  const stream = new Blob([packed as BlobPart]).stream();
  const reader = stream.pipeThrough(new DecompressionStream("gzip")).getReader();
  let filled = 0;
  for (;;) {
    let part: ReadableStreamReadResult<Uint8Array>;
    try {
      part = await reader.read();
    } catch {
      throw damaged("gzip ends early or is broken");
    }
    if (part.done) break;
    if (filled + part.value.length > size) {
      await reader.cancel();
      throw damaged(`more than the ${size} bytes that its count asks for`);
    }
    out.set(part.value, filled);
    filled += part.value.length;
  }
  if (filled !== size) throw damaged(`${filled} bytes of the ${size} that its count asks for`);
  return out;
}

/** The planes of a stream, after its codec. */
async function planesOf(stream: Stream, block: Block, bytes: Uint8Array): Promise<Uint8Array> {
  const where = `${block.name}, ${stream.name}`;
  const width = BYTES_OF[stream.type];
  if (width === undefined)
    throw new PlayerError(`${where}: type "${stream.type}" is not known here; take a newer player`);
  const size = stream.count * stream.components * width;
  const packed = bytes.subarray(stream.offset, stream.offset + stream.bytes);
  if (stream.codec === "gzip") return gunzip(packed, size, where);
  if (stream.codec !== "none")
    throw new PlayerError(
      `${where}: codec "${stream.codec}" is not known here; take a newer player`,
    );
  if (packed.length !== size)
    throw new PlayerError(`${where}: ${packed.length} bytes, expected ${size}; export again`);
  return packed;
}

/** Component c of all rows: bytes put together and, where stored so, differences undone. */
function integersOf(stream: Stream, planes: Uint8Array, c: number): Uint32Array {
  const n = stream.count;
  const width = BYTES_OF[stream.type];
  const values = new Uint32Array(n);
  for (let b = 0; b < width; ++b) {
    const plane = planes.subarray((c * width + b) * n, (c * width + b + 1) * n);
    const shift = 8 * b;
    for (let i = 0; i < n; ++i) values[i] |= plane[i] << shift;
  }
  if (stream.delta) {
    const mask = width === 4 ? 0xffffffff : 2 ** (8 * width) - 1;
    let last = 0;
    for (let i = 0; i < n; ++i) {
      const z = values[i];
      last = (last + ((z >>> 1) ^ -(z & 1))) & mask;
      values[i] = last;
    }
  }
  return values;
}

/** Values of a stream, row by row. */
async function valuesOf(stream: Stream, block: Block, bytes: Uint8Array): Promise<Float32Array> {
  const planes = await planesOf(stream, block, bytes);
  const values = new Float32Array(stream.count * stream.components);
  for (let c = 0; c < stream.components; ++c) {
    const integers = integersOf(stream, planes, c);
    const floats = stream.type === "f32" ? new Float32Array(integers.buffer) : null;
    const scale = stream.scale[c];
    const bias = stream.bias[c];
    for (let i = 0, k = c; i < stream.count; ++i, k += stream.components)
      values[k] = floats ? floats[i] : bias + scale * integers[i];
  }
  return values;
}

/** Throws PlayerError unless all are finite; returns them. */
export function finite(values: Float32Array, name: string, { name: file }: Block): Float32Array {
  if (!values.every(Number.isFinite))
    throw new PlayerError(`${file}: ${name} has a value that is not finite; export again`);
  return values;
}

/** Reads streams of one block by name. */
export class StreamReader {
  constructor(
    private readonly block: Block,
    private readonly bytes: Uint8Array,
  ) {}
  private find(name: string): Stream | undefined {
    return this.block.streams.find((stream) => stream.name === name);
  }
  has(name: string): boolean {
    return this.find(name) !== undefined;
  }
  private async read(stream: Stream, components: number): Promise<Float32Array> {
    if (stream.components !== components)
      throw new PlayerError(
        `${this.block.name}, ${stream.name}: ${stream.components} components, ` +
          `expected ${components}; export the scene again`,
      );
    return valuesOf(stream, this.block, this.bytes);
  }
  /** A stream that each Gaussian must have. */
  async all(name: string, components: number): Promise<Float32Array> {
    const stream = this.find(name);
    if (stream === undefined || stream.count !== this.block.count)
      throw new PlayerError(
        `${this.block.name}: ${stream?.count ?? 0} of ${this.block.count} Gaussians have ` +
          `${name}; export the scene again`,
      );
    return this.read(stream, components);
  }
  /** A stream with a row for each node, or for each control point. */
  async ofNodes(name: string, components: number): Promise<Float32Array> {
    const stream = this.find(name);
    const rows = nodeRows(name, this.block);
    if (stream === undefined || stream.count !== rows)
      throw new PlayerError(
        `${this.block.name}: ${name} has ${stream?.count ?? 0} of ${rows} rows; ` +
          `export the scene again`,
      );
    return finite(await this.read(stream, components), name, this.block);
  }
  /** A stream that the first Gaussians may have. */
  async first(name: string, components: number): Promise<Float32Array> {
    const stream = this.find(name);
    return stream ? this.read(stream, components) : new Float32Array(0);
  }
}
