// A Tessera 4D file as an object of a three.js scene that Spark draws: no page, no camera and no
// clock of its own. Blocks are fetched, decoded in a worker and released as time passes. Source:
// docs/reference/tessera4d.md.
import type { SparkRenderer, SparkRendererOptions } from "@sparkjsdev/spark";
import * as THREE from "three";
import { BlocksContent } from "../../player/blocks_content";
import { bytesSource, folderSource, singleFileSource, type BlockSource } from "../../player/container";
import { fetchBytes, nameOf } from "../../player/fetching";
import type { Progress } from "../../player/loading";
import { FORMAT, parseJson, type Bounds, type Camera, type Triple } from "../../player/manifest";
import { PlayerError } from "../../player/player_error";

export type { Bounds, Camera, Progress, Triple };
/** An error that a user can act on: its message names the file and the remedy. */
export { PlayerError as Tessera4dError };

export interface LoadOptions {
  /** Called as bytes arrive that the current time needs. */
  onProgress?: (progress: Progress) => void;
  /** Called when the image is outdated because data has arrived; for pages that draw on demand. */
  onChange?: () => void;
}

/** How time passes from here, so that what comes next is fetched in advance. */
export interface Playback {
  /** Seconds; negative: backwards; 0: paused. */
  ahead?: number;
  loop?: boolean;
}

const AHEAD = 2; // seconds

/** Options with which Spark orders splats as the program does when it trains them. */
export const sparkOptions = {
  accumExtSplats: true,
  sortRadial: false,
  enableLod: false,
  maxPixelRadius: 8192,
} satisfies Partial<SparkRendererOptions>;

export class Tessera4d extends THREE.Group {
  /** Seconds. */
  readonly duration: number;
  /** Frames a second of the capture; null: not known. */
  readonly fps: number | null;
  /** Against gravity, in the object's own axes; captures mostly have +y down. */
  readonly upwards: THREE.Vector3;
  /** Of most Gaussians, in the object's own axes; null: not known. */
  readonly bounds: THREE.Box3 | null;
  readonly cameras: Camera[];
  /** Of all times; of a file of windows the most at a time. */
  readonly gaussians: number;
  /** sRGB, what the model was trained on. */
  readonly background: THREE.Color;
  private readonly content: BlocksContent;
  private readonly eye = new THREE.Vector3();
  private t = 0; // 0 to 1

  /** To be made by loadTessera4d. */
  constructor(
    private readonly source: BlockSource,
    options: LoadOptions,
  ) {
    super();
    const { manifest } = source;
    const eye = () => this.eye.toArray() as Triple;
    const nothing = () => undefined;
    const { onProgress = nothing, onChange = nothing } = options;
    this.content = new BlocksContent(source, this, eye, onProgress, onChange);
    const { time, up, bounds, cameras, gaussians } = this.content.info;
    this.duration = time.duration;
    this.fps = time.fps;
    this.upwards = new THREE.Vector3(...up);
    this.bounds = bounds && new THREE.Box3(new THREE.Vector3(...bounds.min), new THREE.Vector3(...bounds.max));
    this.cameras = cameras;
    this.gaussians = gaussians;
    const [r, g, b] = manifest.background;
    this.background = new THREE.Color().setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace);
  }

  /**
   * To be called before each image: the Gaussians are those of `seconds`, and their colours those
   * that `camera` sees. Returns whether anything has changed since the last call.
   */
  update(seconds: number, camera: THREE.Camera, { ahead = AHEAD, loop = true }: Playback = {}): boolean {
    const length = this.duration || 1;
    this.t = Math.min(1, Math.max(0, seconds / length));
    this.updateWorldMatrix(true, false);
    camera.updateWorldMatrix(true, false);
    const eye = this.worldToLocal(new THREE.Vector3().setFromMatrixPosition(camera.matrixWorld));
    const seen = !eye.equals(this.eye);
    this.eye.copy(eye);
    return this.content.show(this.t, { ahead: ahead / length, loop }, seen);
  }

  /** Whether data of the time of the last update is on its way. */
  get waiting(): boolean {
    return this.content.waiting(this.t);
  }

  /** Why data of that time is missing and stays so; null: it is not. */
  get trouble(): string | null {
    return this.content.trouble(this.t);
  }

  /** Has Spark filter and cut off splats as this file was trained. */
  configure(spark: SparkRenderer): void {
    const { splat } = this.source.manifest;
    spark.preBlurAmount = splat.compensated ? 0 : splat.dilation;
    spark.blurAmount = splat.compensated ? splat.dilation : 0;
    spark.maxStdDev = splat.cutoffSigma;
    spark.minAlpha = splat.cutoffAlpha;
  }

  /** The highest degree of view-dependent colours that is drawn, 0 to 3. */
  setShDegree(degree: number): void {
    this.content.setShDegree(degree);
  }

  dispose(): void {
    this.content.dispose();
    this.removeFromParent();
  }
}

async function sourceAt(url: string): Promise<BlockSource> {
  if (/\.t4d$/i.test(new URL(url).pathname)) return singleFileSource(url, {});
  const json = parseJson(new TextDecoder().decode((await fetchBytes(url)).bytes), nameOf(url));
  if (json.format !== FORMAT)
    throw new PlayerError(`${nameOf(url)}: is no manifest of a Tessera 4D file`);
  return folderSource(json, url);
}

/**
 * Opens a `.t4d`, a folder by the address of its manifest.json, or the bytes of a `.t4d`. Only the
 * manifest has been read when this resolves. Throws Tessera4dError.
 */
export async function loadTessera4d(
  from: string | URL | ArrayBuffer | Uint8Array,
  options: LoadOptions = {},
): Promise<Tessera4d> {
  if (from instanceof ArrayBuffer) from = new Uint8Array(from);
  const source =
    from instanceof Uint8Array
      ? bytesSource(from, "the Tessera 4D file", null)
      : await sourceAt(new URL(from, document.baseURI).href);
  return new Tessera4d(source, options);
}
