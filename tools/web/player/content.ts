// The interface to the content of a stage at one time: blocks in continuous time or frames of a
// sequence.
import type { Hit, Ray } from "./pick";
import type { Play, SceneInfo } from "./scene_view";

export interface Content {
  readonly info: SceneInfo;
  /**
   * Makes the scene hold time t and sees to what comes next. `seen`: the camera has moved since.
   * True where the frame has to be drawn anew.
   */
  show(t: number, play: Play, seen: boolean): boolean;
  /** Fetches what time t needs and shows nothing of it; true when all of it is here. */
  prepare(t: number, play: Play): boolean;
  /** Whether data of t is on its way. */
  waiting(t: number): boolean;
  /** Why data of t is missing and stays so; null when nothing is missing. */
  trouble(t: number): string | null;
  /** Of view-dependent colours, where the content can leave some out. */
  setShDegree(degree: number): void;
  /** What a ray meets at t, in any order; nothing where the content does not know. */
  hits(ray: Ray, t: number): Hit[];
  dispose(): void;
}
