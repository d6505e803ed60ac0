// What: blocks decoded in a worker, or on this thread where a browser starts none.
// Not: the decoding (tessera4d.ts, packing.ts).
import DecodeWorker from "./decode_worker?worker&inline";
import type { DecodeAnswer, DecodeTask } from "./decode_worker";
import type { Block } from "./manifest";
import { packBlock, type PackedBlock } from "./packing";
import { PlayerError } from "./player_error";
import { decodeBlock } from "./tessera4d";

interface Waiting {
  resolve(packed: PackedBlock): void;
  reject(error: Error): void;
}

export class Decoder {
  private worker: Worker | null = null;
  private readonly waiting = new Map<number, Waiting>();
  private tasks = 0;

  constructor() {
    try {
      this.worker = new DecodeWorker();
    } catch {
      return; // this thread decodes
    }
    this.worker.onmessage = ({ data }: MessageEvent<DecodeAnswer>) => {
      const task = this.waiting.get(data.id);
      this.waiting.delete(data.id);
      if ("packed" in data) task?.resolve(data.packed);
      else task?.reject(new PlayerError(data.line));
    };
    this.worker.onerror = (event) => {
      event.preventDefault();
      for (const task of this.waiting.values())
        task.reject(new PlayerError("decoding stopped (memory?); close other pages and reload"));
      this.waiting.clear();
    };
  }

  /** Throws PlayerError where the block is not what its manifest says. */
  async decode(block: Block, bytes: Uint8Array): Promise<PackedBlock> {
    const { worker } = this;
    if (worker === null) return packBlock(await decodeBlock(block, bytes));
    const own = bytes as Uint8Array<ArrayBuffer>;
    return new Promise((resolve, reject) => {
      const task: DecodeTask = { id: ++this.tasks, block, bytes: own };
      this.waiting.set(task.id, { resolve, reject });
      worker.postMessage(task, [own.buffer]);
    });
  }

  dispose(): void {
    this.worker?.terminate();
    this.waiting.clear();
  }
}
