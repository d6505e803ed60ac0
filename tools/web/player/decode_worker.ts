// The worker thread that checks, decodes and packs blocks, so that playback does not stutter.
import { allArrays, packBlock, type PackedBlock } from "./packing";
import { lineOf } from "./player_error";
import { decodeBlock } from "./tessera4d";
import type { Block } from "./manifest_blocks";

export interface DecodeTask {
  id: number;
  block: Block;
  bytes: Uint8Array<ArrayBuffer>;
}

/** The first one is "ready". */
export type DecodeAnswer = "ready" | ({ id: number } & DecodeResult);
type DecodeResult = { packed: PackedBlock } | { line: string };

self.onmessage = async ({ data }: MessageEvent<DecodeTask>) => {
  const answer = (message: DecodeAnswer, moved: Transferable[] = []) =>
    self.postMessage(message, { transfer: moved });
  try {
    const packed = packBlock(await decodeBlock(data.block, data.bytes));
    const buffers = allArrays(packed).map(({ buffer }) => buffer as ArrayBuffer);
    answer({ id: data.id, packed }, buffers);
  } catch (error) {
    answer({ id: data.id, line: lineOf(error) });
  }
};

self.postMessage("ready" satisfies DecodeAnswer);
