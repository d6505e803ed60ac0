// The sources of blocks of a Tessera 4D file: a folder on a server, a single file on a server (by
// ranges, or whole where the server supports none), or a single file within the page. Source:
// docs/reference/tessera4d.md, section 2.
import { fetchBytes, nameOf, type FetchOptions } from "./fetching";
import { parseJson, readManifest, VERSION, type Manifest } from "./manifest";
import type { Block } from "./manifest_blocks";
import { PlayerError } from "./player_error";

export interface BlockSource {
  readonly manifest: Manifest;
  /** What `manifest.audio` is relative to; null within a page. */
  readonly address: string | null;
  fetchBlock(block: Block, options: FetchOptions): Promise<Uint8Array>;
}

const HEAD = 12; // bytes before the manifest of a single file
const FIRST_READ = 1 << 18; // bytes: enough for the manifest of a clip of many minutes

/** A folder: one file for each block. `json`: its manifest.json, parsed. */
export function folderSource(json: unknown, url: string): BlockSource {
  const manifest = readManifest(json, nameOf(url));
  for (const block of manifest.blocks)
    if (block.file === null)
      throw new PlayerError(`${nameOf(url)}: ${block.name} names no file; export the scene again`);
  return {
    manifest,
    address: url,
    async fetchBlock(block, options) {
      const address = new URL(block.file!, url).href;
      return (await fetchBytes(address, options)).bytes;
    },
  };
}

/** Length of the manifest, from the first bytes of a single file. */
function manifestLength(bytes: Uint8Array, name: string): number {
  const magic = String.fromCharCode(...bytes.subarray(0, 4));
  if (bytes.length < HEAD || magic !== "TES4")
    throw new PlayerError(`${name}: no Tessera 4D file (it does not begin with TES4); check scene`);
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const version = view.getUint32(4, true);
  if (version > VERSION)
    throw new PlayerError(
      `${name}: version ${version} is later than this player knows (${VERSION}); ` +
        `take the page of the export that wrote it`,
    );
  return view.getUint32(8, true);
}

function manifestOf(bytes: Uint8Array, length: number, name: string): Manifest {
  if (bytes.length < HEAD + length)
    throw new PlayerError(
      `${name}: its manifest has ${length} bytes, ${Math.max(0, bytes.length - HEAD)} are there, ` +
        `so it is cut off; copy it again`,
    );
  const text = new TextDecoder().decode(bytes.subarray(HEAD, HEAD + length));
  const manifest = readManifest(parseJson(text, name), name);
  for (const block of manifest.blocks) {
    if (block.file !== null)
      throw new PlayerError(`${name}: ${block.name} is not in this file; export the scene again`);
    block.name = `${name}, ${block.name}`;
  }
  return manifest;
}

/** A single file that is all here. */
export function bytesSource(bytes: Uint8Array, name: string, address: string | null): BlockSource {
  const length = manifestLength(bytes, name);
  const manifest = manifestOf(bytes, length, name);
  const first = HEAD + length;
  return {
    manifest,
    address,
    fetchBlock: async (block) =>
      bytes.slice(first + block.offset, first + block.offset + block.bytes),
  };
}

/** A single file on a server. */
export async function singleFileSource(url: string, options: FetchOptions): Promise<BlockSource> {
  const name = nameOf(url);
  const head = await fetchBytes(url, { ...options, range: { offset: 0, bytes: FIRST_READ } });
  if (head.whole) return bytesSource(head.bytes, name, url);
  const length = manifestLength(head.bytes, name);
  const bytes =
    HEAD + length <= head.bytes.length
      ? head.bytes
      : (await fetchBytes(url, { ...options, range: { offset: 0, bytes: HEAD + length } })).bytes;
  const manifest = manifestOf(bytes, length, name);
  return {
    manifest,
    address: url,
    async fetchBlock(block, blockOptions) {
      if (block.bytes === 0) return new Uint8Array(0);
      const range = { offset: HEAD + length + block.offset, bytes: block.bytes };
      const end = range.offset + range.bytes;
      if (end <= bytes.length) return bytes.slice(range.offset, end); // came with the manifest
      const part = await fetchBytes(url, { ...blockOptions, range });
      return part.whole
        ? part.bytes.slice(range.offset, end) : part.bytes;
    },
  };
}

/** Base64 text -> bytes, without a request. */
export function bytesOfBase64(text: string): Uint8Array {
  let binary: string;
  try {
    binary = atob(text);
  } catch {
    throw new PlayerError("the scene within this page is damaged (no base64); export it again");
  }
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}
