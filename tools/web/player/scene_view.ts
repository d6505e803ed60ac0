// The interface between the page and a renderer: a few calls and a camera. spark_view.ts implements
// it; another engine would be a second implementation.
import type { Bounds, Camera, Quaternion, Triple } from "./manifest";
import type { Progress } from "./loading";
import type { Ray } from "./pick";
import type { OpenedSource } from "./open_source";

/** A pinhole's view of width × height pixels; what lies beside it is shown too. */
export interface Lens {
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  width: number;
  height: number;
}

/** Where the view is taken from. Whoever changes it counts `version` up. */
export interface ViewCamera {
  position: Triple; // world units
  rotation: Quaternion; // camera axes (right, down, forward) into the world
  lens: Lens;
  whole: boolean; // the lens's image is to be seen whole, also in an upright window
  version: number;
}

export interface SceneInfo {
  time: { origin: number; duration: number; fps: number | null }; // seconds
  /** Times of the frames of a sequence, in t, ascending; null: any time can be drawn. */
  frames: number[] | null;
  up: Triple;
  bounds: Bounds | null;
  cameras: Camera[];
  gaussians: number; // of a sequence: of its largest frame; of windows: the most at a time
  audio: string | null; // address
}

/** How play continues from the time that is drawn. */
export interface Play {
  ahead: number; // t to fetch in advance; negative: backwards; 0: paused
  loop: boolean;
}

export interface Drawn {
  waiting: boolean;
  complete: boolean;
  trouble: string | null;
}

/** Called as the bytes arrive that the image in view needs. */
export type OnProgress = (progress: Progress) => void;

export interface SceneView {
  /**
   * Reads what the scene is. A scene that is shown stays until the next one can be drawn. Throws
   * PlayerError.
   */
  load(source: OpenedSource, onProgress: OnProgress): Promise<SceneInfo>;
  /**
   * Draws time t (0 to 1) from the camera, if that or anything else has changed since; called
   * for every frame of the display. Tells whether data of t is on its way, whether the image on
   * the screen is that of t (data, depth order, pixels), and what is missing.
   */
  setTime(t: number, play: Play): Drawn;
  /** sRGB, 0 to 255; null: that of the scene. */
  setBackground(colour: Triple | null): void;
  /** The image on the screen as a PNG. */
  image(): Promise<Blob | null>;
  /** The highest degree of view-dependent colours that is drawn, 0 to 3; frames have all of theirs. */
  setShDegree(degree: number): void;
  /** Depth of what a ray meets first at the time that is drawn; null: nothing, or not known. */
  pick(ray: Ray): number | null;
  /** Whether the scene is in a headset, and not on the page. */
  readonly inVr: boolean;
  /** Into the headset, at a press of the person, with `onFrame` called for each of its images. */
  enterVr(onFrame: () => void, onEnd: () => void): Promise<void>;
  leaveVr(): void;
  /** Size of the view in CSS pixels, and device pixels for each of them. */
  resize(width: number, height: number, dpr: number): void;
  /** Resolves when the frame of the last time is complete: data, depth order, pixels. */
  settle(): Promise<void>;
  dispose(): void;
}
