// Decodes blocks in a worker, or on this thread where a browser starts none.
import DecodeWorker from "./decode_worker?worker&inline";
import type { DecodeAnswer, DecodeTask } from "./decode_worker";
import type { Block } from "./manifest_blocks";
import { packBlock, type PackedBlock } from "./packing";
import { PlayerError } from "./player_error";
import { decodeBlock } from "./tessera4d";

interface Waiting {
  resolve(packed: PackedBlock): void;
  reject(error: Error): void;
}

export class Decoder {
  private readonly waiting = new Map<number, Waiting>();
  private tasks = 0;
  /** null: this thread decodes. */
  private readonly worker: Promise<Worker | null> = this.start();

  private start(): Promise<Worker | null> {
    return new Promise((resolve) => {
      let worker: Worker;
      try {
        worker = new DecodeWorker();
      } catch {
        return resolve(null);
      }
      worker.onmessage = ({ data }: MessageEvent<DecodeAnswer>) =>
        data === "ready" ? resolve(worker) : this.take(data);
      worker.onerror = (event) => {
        event.preventDefault();
        resolve(null); // where it never was ready
        for (const task of this.waiting.values())
          task.reject(new PlayerError("decoding stopped (memory?); close other pages and reload"));
        this.waiting.clear();
      };
    });
  }

  private take(answer: Exclude<DecodeAnswer, "ready">): void {
    const task = this.waiting.get(answer.id);
    this.waiting.delete(answer.id);
    if ("packed" in answer) task?.resolve(answer.packed);
    else task?.reject(new PlayerError(answer.line));
  }

  /** Throws PlayerError where the block is not what its manifest says. */
  async decode(block: Block, bytes: Uint8Array): Promise<PackedBlock> {
    const worker = await this.worker;
    if (worker === null) return packBlock(await decodeBlock(block, bytes));
    const owned = bytes as Uint8Array<ArrayBuffer>;
    return new Promise((resolve, reject) => {
      const task: DecodeTask = { id: ++this.tasks, block, bytes: owned };
      this.waiting.set(task.id, { resolve, reject });
      worker.postMessage(task, [owned.buffer]);
    });
  }

  dispose(): void {
    void this.worker.then((worker) => worker?.terminate());
    this.waiting.clear();
  }
}
