// Shows a sequence of frame files on a stage: one mesh whose data is swapped, and a ring of decoded
// frames around the current time. While a frame is late, the last one stays. Spark decodes the
// formats.
import { ExtSplats, SplatFileType, SplatMesh } from "@sparkjsdev/spark";
import { BlockCache } from "./blocks";
import type { Content } from "./content";
import { fetchBytes } from "./fetching";
import { Arrivals } from "./loading";
import { memoryBudget } from "./memory_budget";
import { lineOf, PlayerError } from "./player_error";
import type { Hit } from "./pick";
import type { OnProgress, Play, SceneInfo } from "./scene_view";
import type { Sequence } from "./sequence_manifest";
import type { Stage } from "./stage";

const TYPES = {
  ply: SplatFileType.PLY,
  spz: SplatFileType.SPZ,
  splat: SplatFileType.SPLAT,
} as const;

interface Frame {
  splats: ExtSplats;
  memory: number;
}

/** Each frame is seen from half way to its neighbour before to half way to the one after. */
function spansOf(times: number[]): { visible: [number, number] }[] {
  const half = (i: number) => (times[i] + times[i + 1]) / 2;
  return times.map((_, i) => ({
    visible: [i === 0 ? -Infinity : half(i - 1), i + 1 === times.length ? Infinity : half(i)],
  }));
}

/** Bytes of a decoded frame: two textures of 16 bytes a splat, and SH as Spark packs it. */
function memoryOf(splats: ExtSplats): number {
  const sh = Object.values(splats.extra).filter((value) => value instanceof Uint32Array);
  return [...splats.extArrays, ...sh].reduce((sum, array) => sum + array.byteLength, 0);
}

export class FramesContent implements Content {
  readonly info: SceneInfo;
  private readonly cache: BlockCache<Frame>;
  private readonly mesh: SplatMesh;
  private readonly arrivals: Arrivals;
  private shown: Frame | null = null;
  private t = 0;

  constructor(
    private readonly sequence: Sequence,
    stage: Stage,
    onProgress: OnProgress,
    onChange: () => void,
  ) {
    const times = sequence.frames.map(({ t }) => t);
    this.info = {
      time: sequence.time,
      frames: times,
      up: sequence.up,
      bounds: sequence.bounds,
      cameras: sequence.cameras,
      gaussians: Math.max(...sequence.frames.map(({ gaussians }) => gaussians)),
      audio: null,
    };
    this.mesh = new SplatMesh({ extSplats: new ExtSplats(), editable: false, raycastable: false });
    // .spz files look right, up and backwards: a half turn about x
    if (sequence.fileType === "spz") this.mesh.quaternion.set(1, 0, 0, 0);
    stage.add(this.mesh);
    const sizes = sequence.frames.map(({ bytes }) => bytes);
    const report = () => onProgress(this.arrivals.of(this.cache.at(this.t).slice(0, 1)));
    this.arrivals = new Arrivals(sizes, report);
    this.cache = new BlockCache<Frame>(spansOf(times), memoryBudget(), {
      load: (i, signal) => this.load(i, signal),
      release: (frame) => {
        // the last frame stays on the screen until another takes its place
        if (frame !== this.shown) frame.splats.dispose();
      },
      onChange,
    });
  }

  private async load(i: number, signal: AbortSignal): Promise<Frame> {
    const { url, name } = this.sequence.frames[i];
    const onBytes = (count: number) => this.arrivals.add(i, count);
    this.arrivals.begin(i);
    const { bytes } = await fetchBytes(url, { signal, onBytes });
    this.arrivals.end(i);
    const splats = new ExtSplats({
      fileBytes: bytes,
      fileName: name,
      fileType: TYPES[this.sequence.fileType],
    });
    try {
      await splats.initialized;
    } catch (error) {
      throw new PlayerError(
        `${name}: cannot be decoded (${lineOf(error).slice(0, 80)}); copy or export it again`,
      );
    }
    return { splats, memory: memoryOf(splats) };
  }

  prepare(t: number, { ahead, loop }: Play): boolean {
    this.cache.update({ t, ahead, loop });
    return !this.cache.waiting(t);
  }

  show(t: number, play: Play, seen: boolean): boolean {
    this.t = t;
    this.cache.update({ t, ...play });
    const index = this.cache.at(t)[0];
    const frame = index === undefined ? undefined : this.cache.get(index);
    if (frame === undefined || frame === this.shown) return seen;
    const last = this.shown;
    this.shown = frame;
    this.mesh.extSplats = frame.splats;
    this.mesh.splats = frame.splats;
    this.mesh.updateVersion();
    if (last !== null && !this.holds(last)) last.splats.dispose();
    return true;
  }

  private holds(frame: Frame): boolean {
    return this.sequence.frames.some((_, i) => this.cache.get(i) === frame);
  }

  waiting(t: number): boolean {
    return this.cache.waiting(t);
  }

  trouble(t: number): string | null {
    return this.cache.trouble(t);
  }

  /** Spark draws frames with all that they have. */
  setShDegree(): void {}

  /** Spark keeps the Gaussians of frames to itself. */
  hits(): Hit[] {
    return [];
  }

  dispose(): void {
    this.cache.dispose();
    this.mesh.dispose();
  }
}
