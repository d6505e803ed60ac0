// What: a Tessera 4D file on a stage: blocks of the moment are in the scene, the shader moves them.
// Not: which blocks to have (blocks.ts), decoding (decoder.ts), the shader (splat4d_shader.ts).
import { BlockCache } from "./blocks";
import type { BlockSource } from "./container";
import type { Content } from "./content";
import { Decoder } from "./decoder";
import { memoryBudget } from "./memory_budget";
import type { Play, Progress, SceneInfo, ViewCamera } from "./scene_view";
import { BlockSplats, Moment } from "./splat4d_shader";
import type { Stage } from "./stage";

export class BlocksContent implements Content {
  readonly info: SceneInfo;
  private readonly moment = new Moment();
  private readonly decoder = new Decoder();
  private readonly cache: BlockCache<BlockSplats>;
  private t = NaN;
  private shown = "";
  private bytes = 0;

  constructor(
    private readonly source: BlockSource,
    private readonly stage: Stage,
    private readonly view: ViewCamera,
    private readonly progress: Progress,
    onChange: () => void,
  ) {
    const { manifest, address } = source;
    const clip = Number(manifest.anchor === "clip");
    this.moment.when.value.set(0, clip, manifest.splat.cutoffAlpha, 0);
    this.info = {
      time: manifest.time,
      frames: null,
      up: manifest.up,
      bounds: manifest.bounds,
      cameras: manifest.cameras,
      gaussians: manifest.gaussians.static + manifest.gaussians.dynamic,
      audio: manifest.audio && address ? new URL(manifest.audio, address).href : null,
    };
    this.cache = new BlockCache<BlockSplats>(manifest.blocks, memoryBudget(), {
      load: (i, signal) => this.load(i, signal),
      release: (splats) => {
        splats.removeFromParent();
        splats.dispose();
      },
      onChange,
    });
  }

  private async load(i: number, signal: AbortSignal): Promise<BlockSplats> {
    const block = this.source.manifest.blocks[i];
    const needed = this.cache
      .at(Number.isNaN(this.t) ? 0 : this.t)
      .reduce((sum, k) => sum + this.source.manifest.blocks[k].bytes, 0);
    const onBytes = (count: number) => this.progress((this.bytes += count), needed);
    const bytes = await this.source.fetchBlock(block, { signal, onBytes });
    return new BlockSplats(await this.decoder.decode(block, bytes), this.moment);
  }

  show(t: number, play: Play, seen: boolean): boolean {
    const moved = t !== this.t;
    this.t = t;
    this.cache.update({ t, ...play });
    const splats = this.cache.at(t).map((i) => this.cache.get(i));
    const present = splats.filter((block): block is BlockSplats => block !== undefined);
    const names = present.map((block) => block.id).join();
    const changed = names !== this.shown;
    if (changed) this.place(present);
    this.shown = names;
    if (!moved && !seen && !changed) return false;
    this.moment.when.value.x = t;
    this.moment.eye.value.set(...this.view.position);
    for (const block of present) block.updateVersion();
    return true;
  }

  /** Exactly these are in the scene, in the file's order: depth ties fall as they always do. */
  private place(present: BlockSplats[]): void {
    for (const child of [...this.stage.scene.children])
      if (child instanceof BlockSplats) child.removeFromParent();
    for (const block of present) this.stage.add(block);
  }

  waiting(t: number): boolean {
    return this.cache.waiting(t);
  }

  trouble(t: number): string | null {
    return this.cache.trouble(t);
  }

  dispose(): void {
    this.cache.dispose();
    this.decoder.dispose();
  }
}
