// Eased moves of the camera from one view to another: its target, distance, rotation and lens
// change together, so that it moves around the scene and not through it.
import * as THREE from "three";
import type { Lens } from "./scene_view";
import type { Pose } from "./view_camera";

const SECONDS = 0.7; // of a move

export function focusOf({ position, rotation, distance }: Pose): THREE.Vector3 {
  return new THREE.Vector3(0, 0, distance).applyQuaternion(rotation).add(position);
}

function between(a: number, b: number, share: number): number {
  return a + (b - a) * share;
}

export function lensBetween(a: Lens, b: Lens, share: number): Lens {
  const mixed = (key: keyof Lens) => between(a[key], b[key], share);
  return {
    fx: mixed("fx"),
    fy: mixed("fy"),
    cx: mixed("cx"),
    cy: mixed("cy"),
    width: mixed("width"),
    height: mixed("height"),
  };
}

/** `share`: 0 is `from`, 1 is `to`. */
export function poseBetween(from: Pose, to: Pose, share: number): Pose {
  const rotation = from.rotation.clone().slerp(to.rotation, share);
  const logs = [Math.log(from.distance), Math.log(to.distance)];
  const distance = Math.exp(between(logs[0], logs[1], share));
  const focus = focusOf(from).lerp(focusOf(to), share);
  const position = focus.sub(new THREE.Vector3(0, 0, distance).applyQuaternion(rotation));
  return { position, rotation, distance, lens: lensBetween(from.lens, to.lens, share) };
}

/** Slow at both ends; 0 to 1 → 0 to 1. */
export function eased(share: number): number {
  return share * share * (3 - 2 * share);
}

/** At most one move at a time. It is over when the exact pose of its end has been set. */
export class Moves {
  private move: { from: Pose; to: Pose; begin: number } | null = null;

  /** `wall`: seconds; `still`: whether the person prefers no motion. */
  constructor(
    private readonly setPose: (pose: Pose) => void,
    private readonly wall: () => number,
    private readonly still: () => boolean,
  ) {}

  start(from: Pose, to: Pose): void {
    this.move = { from, to, begin: this.wall() };
    if (this.still()) this.finish();
  }

  /** To be called before each image. */
  step(): void {
    if (this.move === null) return;
    const share = (this.wall() - this.move.begin) / SECONDS;
    if (share >= 1) return this.finish();
    this.setPose(poseBetween(this.move.from, this.move.to, eased(share)));
  }

  /** At once at its end. */
  finish(): void {
    if (this.move !== null) this.setPose(this.move.to);
    this.move = null;
  }

  /** Stays where it is: the person has taken the camera. */
  stop(): void {
    this.move = null;
  }
}
