// The current viewpoint: a camera of the rig or a free view, the moves between them, and their
// names in the address.
import * as THREE from "three";
import { Flight } from "./fly";
import type { Camera } from "./manifest";
import { Moves } from "./motion";
import { Orbit } from "./orbit";
import { Playback } from "./path";
import type { SceneInfo, SceneView, ViewCamera } from "./scene_view";
import { SeenBounds } from "./seen_bounds";
import { poseOfWord, viewWord } from "./shared_view";
import { rememberInUrl } from "./url_state";
import {
  homePose, isSameView, poseFrom, poseTowards, rayOf, rigPose, type Pose,
} from "./view_camera";

const STAYS_MS = 900; // after which a free view is written into the address

export class Viewpoint {
  private readonly orbit: Orbit;
  private readonly moves: Moves;
  private readonly flight: Flight;
  private readonly playback: Playback;
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  /** Told when the camera begins to move along its path, and when it has ended. */
  onPath: (on: boolean) => void = () => {};
  private shown = -1; // camera of the rig
  private timer = 0;

  /** `onCamera`: told which camera is shown; −1: a free view. */
  constructor(
    private readonly canvas: HTMLElement,
    private readonly camera: ViewCamera,
    private readonly info: SceneInfo,
    private readonly view: SceneView,
    private readonly onCamera: (index: number) => void,
  ) {
    this.orbit = new Orbit(canvas, camera, new THREE.Vector3(...info.up).normalize());
    this.orbit.onMove = () => this.leave();
    this.orbit.onFocus = (point) => this.focusOn(point);
    const setPose = (pose: Pose) => this.orbit.setPose(pose);
    const wall = () => performance.now() / 1000;
    this.moves = new Moves(setPose, wall, () => this.still.matches);
    this.playback = new Playback(info, setPose, wall);
    this.flight = new Flight(this.orbit, info, wall);
  }

  /** As the address has it; words that mean nothing leave the first view. */
  open(camera: string | null, word: string | null, path: boolean): void {
    this.openView(camera, word);
    if (path && !this.still.matches) this.playPath(true);
  }

  private openView(camera: string | null, word: string | null): void {
    this.orbit.setPose(homePose(this.info));
    this.show(this.info.cameras.length > 0 ? 0 : -1);
    if (camera !== null) this.take(this.indexOf(camera));
    this.moves.finish();
    const shared = word === null ? null : poseOfWord(word, this.info);
    if (shared === null) return;
    this.orbit.setPose(shared);
    this.show(-1);
  }

  /** Whether drags and flight stay within what the cameras have seen. */
  stay(within: boolean): void {
    const bounds = within && this.info.cameras.length > 0 ? new SeenBounds(this.info) : null;
    this.orbit.limit = (pose) => {
      if (bounds === null) return pose;
      return this.flight.on ? bounds.standing(pose) : bounds.within(pose);
    };
  }

  get playsPath(): boolean {
    return this.playback.on;
  }

  /** Along the path from the view that is shown; where it ends, the view stays. */
  playPath(on: boolean): void {
    if (!on) return this.leave();
    this.flight.halt();
    this.moves.stop();
    this.show(-1);
    this.playback.start(this.orbit.pose);
    this.onPath(true);
    rememberInUrl({ cam: null, view: null, path: "1" });
  }

  private endPath(): void {
    if (!this.playback.on) return;
    this.playback.stop();
    this.onPath(false);
    rememberInUrl({ path: null });
  }

  get flies(): boolean {
    return this.flight.on;
  }

  /** Flight by keys, or turning about the scene again. */
  fly(on: boolean): void {
    this.flight.switch(on);
    if (on || this.shown >= 0) return;
    this.leave();
    const { position, rotation, lens } = this.orbit.pose;
    this.moveTo(this.orbit.limit(poseFrom(position, rotation, lens, this.info)));
  }

  /** By name, or by number from 1; −1: there is none such. */
  indexOf(text: string): number {
    const named = this.info.cameras.findIndex(({ name }) => name === text);
    return named >= 0 || !/^\d+$/.test(text) ? named : Number(text) - 1;
  }

  /** To be called before each image. */
  step(): void {
    this.flight.step();
    this.moves.step();
    this.playback.step();
  }

  /** Ends a move at once, and a path or a flight where it is. */
  finish(): void {
    if (this.playback.on) this.leave();
    this.flight.halt();
    this.moves.finish();
  }

  reset(): void {
    this.moveTo(homePose(this.info));
    this.show(this.info.cameras.length > 0 ? 0 : -1);
    rememberInUrl({ cam: null, view: null });
  }

  take(index: number): void {
    const camera = this.info.cameras[index];
    if (camera === undefined) return;
    this.moveTo(rigPose(camera, this.info));
    this.show(index);
    rememberInUrl({ cam: camera.name, view: null });
  }

  /** At once to a camera that the rig need not have. */
  look(camera: Camera): void {
    this.finish();
    this.orbit.setPose(rigPose(camera, this.info));
    this.show(this.info.cameras.findIndex((own) => isSameView(own, camera)));
  }

  get word(): string {
    return viewWord(this.camera);
  }

  /** What the address needs to show this view. */
  get values(): { cam: string | null; view: string | null } {
    const camera = this.info.cameras[this.shown];
    if (camera !== undefined) return { cam: camera.name, view: null };
    this.moves.finish();
    return { cam: null, view: this.word };
  }

  private moveTo(pose: Pose): void {
    this.endPath();
    this.flight.halt();
    this.moves.start(this.orbit.pose, pose);
  }

  /** Turns to what is seen at a point of the window, and about it from then on. */
  private focusOn(point: [number, number]): void {
    this.moves.finish();
    const ray = rayOf(this.camera, this.canvas.clientWidth, this.canvas.clientHeight, point);
    const { pose } = this.orbit;
    this.leave();
    this.moveTo(poseTowards(pose, ray, this.view.pick(ray) ?? pose.distance));
  }

  /** The view is the person's own; the address has it once it stays. */
  private leave(): void {
    this.endPath();
    this.moves.stop();
    this.show(-1);
    this.timer = window.setTimeout(() => rememberInUrl(this.values), STAYS_MS);
  }

  private show(index: number): void {
    clearTimeout(this.timer);
    this.shown = index;
    this.onCamera(index);
  }
}
