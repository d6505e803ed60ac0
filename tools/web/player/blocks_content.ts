// Shows a Tessera 4D file in a scene of three.js: blocks of the current time are children of one
// object, and the shader moves them.
import type { Object3D } from "three";
import { blockHits } from "./block_hits";
import { BlockCache } from "./blocks";
import type { BlockSource } from "./container";
import type { Content } from "./content";
import { Decoder } from "./decoder";
import { Arrivals } from "./loading";
import type { Triple } from "./manifest";
import { memoryBudget } from "./memory_budget";
import type { Hit, Ray } from "./pick";
import type { OnProgress, Play, SceneInfo } from "./scene_view";
import { BlockSplats, eyeUniform, SliceUniforms } from "./splat4d_shader";
import { lightAt, ownTime } from "./windows";

const MOST_SH_DEGREE = 3;

export class BlocksContent implements Content {
  readonly info: SceneInfo;
  private readonly eyePlace = eyeUniform();
  private readonly slices: SliceUniforms[]; // of each window; the last: of blocks without one
  private readonly decoder = new Decoder();
  private readonly cache: BlockCache<BlockSplats>;
  private readonly arrivals: Arrivals;
  private t = NaN;
  private shown = "";

  constructor(
    private readonly source: BlockSource,
    private readonly parent: Object3D,
    private readonly eye: () => Triple,
    onProgress: OnProgress,
    onChange: () => void,
  ) {
    const { manifest, address } = source;
    const clip = Number(manifest.anchor === "clip");
    this.slices = [...manifest.windows, null].map(() => {
      const slice = new SliceUniforms(this.eyePlace);
      slice.when.value.set(0, clip, manifest.splat.cutoffAlpha, MOST_SH_DEGREE);
      return slice;
    });
    this.info = {
      time: manifest.time,
      frames: null,
      up: manifest.up,
      bounds: manifest.bounds,
      cameras: manifest.cameras,
      gaussians:
        manifest.peak ?? Object.values(manifest.gaussians).reduce((sum, count) => sum + count, 0),
      audio: manifest.audio && address ? new URL(manifest.audio, address).href : null,
    };
    const sizes = manifest.blocks.map(({ bytes }) => bytes);
    const report = () => onProgress(this.arrivals.of(this.cache.at(this.t)));
    this.arrivals = new Arrivals(sizes, report);
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
    const onBytes = (count: number) => this.arrivals.add(i, count);
    this.arrivals.begin(i);
    const bytes = await this.source.fetchBlock(block, { signal, onBytes });
    this.arrivals.end(i);
    const slice = this.slices[block.window ?? this.source.manifest.windows.length];
    return new BlockSplats(await this.decoder.decode(block, bytes), slice);
  }

  prepare(t: number, play: Play): boolean {
    this.cache.update({ t, ...play });
    return !this.cache.waiting(t);
  }

  show(t: number, play: Play, seen: boolean): boolean {
    const moved = t !== this.t;
    this.t = t;
    this.cache.update({ t, ...play });
    const indices = this.cache.at(t).filter((i) => this.cache.get(i) !== undefined);
    const present = indices.map((i) => this.cache.get(i)!);
    const names = present.map((block) => block.id).join();
    const changed = names !== this.shown;
    if (changed) this.place(present);
    this.shown = names;
    if (!moved && !seen && !changed) return false;
    this.eyePlace.value.set(...this.eye());
    this.slices[this.slices.length - 1].light.value.set(...lightAt(this.source.manifest.windows, t));
    present.forEach((block, k) => {
      block.pose(this.timeOf(indices[k], t));
      block.updateVersion();
    });
    return true;
  }

  /** Of the Gaussians of block i at t of the clip. */
  private timeOf(i: number, t: number): number {
    const { windows, blocks } = this.source.manifest;
    return ownTime(windows, blocks[i].window, t);
  }

  /** Exactly these are in the scene, in the file's order: depth ties fall as they always do. */
  private place(present: BlockSplats[]): void {
    for (const child of [...this.parent.children])
      if (child instanceof BlockSplats) child.removeFromParent();
    for (const block of present) this.parent.add(block);
  }

  waiting(t: number): boolean {
    return this.cache.waiting(t);
  }

  trouble(t: number): string | null {
    return this.cache.trouble(t);
  }

  setShDegree(degree: number): void {
    for (const { when } of this.slices) when.value.w = degree;
    this.t = NaN; // is drawn anew
  }

  hits(ray: Ray, t: number): Hit[] {
    const clip = this.source.manifest.anchor === "clip";
    return this.cache.at(t).flatMap((i) => {
      const packed = this.cache.get(i)?.packed;
      return packed === undefined ? [] : blockHits(packed, ray, this.timeOf(i, t), clip);
    });
  }

  dispose(): void {
    this.cache.dispose();
    this.decoder.dispose();
  }
}
