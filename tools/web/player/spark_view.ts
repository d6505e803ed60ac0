// Implements SceneView on Spark and three.js.
import { BlocksContent } from "./blocks_content";
import type { Content } from "./content";
import { FramesContent } from "./frames_content";
import type { Bounds, SplatRules, Triple } from "./manifest";
import type { OpenedSource } from "./open_source";
import { firstDepth, type Ray } from "./pick";
import type {
  Drawn,
  OnProgress,
  Play,
  SceneInfo,
  SceneView,
  ViewCamera,
} from "./scene_view";
import { Stage } from "./stage";

const NEAR = 0.2; // world units, as the program renders where a file does not say
const LONGEST_MS = 30000; // that settle() waits
const NEAR_OF_RADIUS = 0.02; // of small scenes

function nearOf(bounds: Bounds | null, { near }: SplatRules): number {
  const most = near !== null && near > 0 ? near : NEAR;
  if (bounds === null) return most;
  const size = Math.hypot(...bounds.max.map((high, k) => high - bounds.min[k]));
  return size > 0 ? Math.min(most, (NEAR_OF_RADIUS * size) / 2) : most;
}

/** Resolves when the browser has shown a frame, or after a while where it shows none. */
function nextFrame(): Promise<void> {
  return new Promise((resolve) => {
    const late = setTimeout(resolve, 200);
    requestAnimationFrame(() => {
      clearTimeout(late);
      resolve();
    });
  });
}

export class SparkView implements SceneView {
  private readonly stage: Stage;
  private content: Content | null = null;
  private incoming: Content | null = null; // takes the place of `content` once it is here
  private dirty = true;
  private seen = -1; // version of the camera that was drawn
  private t = 0;
  private play: Play = { ahead: 0, loop: false };
  private disposed = false;
  private background: Triple = [0, 0, 0]; // of the scene
  private chosen: Triple | null = null; // in its place
  private head: Triple | null = null; // in a headset: where an eye is, world units

  /** Throws PlayerError where there is no WebGL2. */
  constructor(
    canvas: HTMLCanvasElement,
    private readonly camera: ViewCamera,
  ) {
    this.stage = new Stage(canvas, camera, () => (this.dirty = true));
  }

  async load(source: OpenedSource, onProgress: OnProgress): Promise<SceneInfo> {
    const drawn: { background: Triple; splat: SplatRules } =
      source.kind === "4d" ? source.blocks.manifest : source.sequence;
    this.background = drawn.background;
    this.stage.setBackground(this.chosen ?? this.background);
    this.stage.setRules(drawn.splat);
    const changed = () => (this.dirty = true);
    const eye = () => this.head ?? this.camera.position;
    const content =
      source.kind === "4d"
        ? new BlocksContent(source.blocks, this.stage.scene, eye, onProgress, changed)
        : new FramesContent(source.sequence, this.stage, onProgress, changed);
    this.stage.near = nearOf(content.info.bounds, drawn.splat);
    if (this.content === null) {
      this.content = content;
    } else {
      this.incoming?.dispose();
      this.incoming = content;
    }
    return content.info;
  }

  setTime(t: number, play: Play): Drawn {
    this.t = t;
    this.play = play;
    if (this.incoming?.prepare(t, play)) {
      this.content?.dispose();
      this.content = this.incoming;
      this.incoming = null;
      this.dirty = true;
    }
    const { content } = this;
    if (content === null) return { waiting: false, complete: false, trouble: null };
    const { headset } = this.stage;
    this.head = headset.on ? ((headset.placeEyes()?.toArray() as Triple) ?? null) : null;
    const seen = this.camera.version !== this.seen || this.head !== null;
    const changed = content.show(t, play, seen);
    const due = headset.on ? this.head !== null : changed || seen || this.dirty;
    if (due) {
      this.dirty = false;
      this.seen = this.camera.version;
      this.stage.draw();
    }
    const waiting = content.waiting(t);
    // the draw before this call was the last one that was due
    const complete = !waiting && (headset.on || (!due && this.stage.sorted));
    return { waiting, complete, trouble: content.trouble(t) };
  }

  setBackground(colour: Triple | null): void {
    this.chosen = colour;
    this.stage.setBackground(colour ?? this.background);
    this.dirty = true;
  }

  image(): Promise<Blob | null> {
    return this.stage.image();
  }

  setShDegree(degree: number): void {
    this.content?.setShDegree(degree);
    this.dirty = true;
  }

  pick(ray: Ray): number | null {
    return this.content === null ? null : firstDepth(this.content.hits(ray, this.t));
  }

  get inVr(): boolean {
    return this.stage.headset.on;
  }

  enterVr(onFrame: () => void, onEnd: () => void): Promise<void> {
    if (this.content === null) return Promise.resolve();
    return this.stage.enterVr(this.content.info, onFrame, () => {
      this.seen = -1; // the page's view is drawn anew
      onEnd();
    });
  }

  leaveVr(): void {
    this.stage.headset.end();
  }

  resize(width: number, height: number, dpr: number): void {
    this.stage.resize(width, height, dpr);
    this.dirty = true;
  }

  async settle(): Promise<void> {
    const deadline = performance.now() + LONGEST_MS; // of a scene that plays on
    for (let quiet = 0; quiet < 2 && !this.disposed && performance.now() < deadline; ) {
      const { waiting } = this.setTime(this.t, this.play);
      await nextFrame();
      quiet = !waiting && !this.dirty && this.stage.sorted ? quiet + 1 : 0;
    }
    this.stage.finish();
    await nextFrame();
  }

  dispose(): void {
    this.disposed = true;
    this.incoming?.dispose();
    this.content?.dispose();
    this.stage.dispose();
  }
}
