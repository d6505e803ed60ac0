// Flight through the scene by held keys: their velocity, eased so that the path is the same at any
// frame rate, and the camera that it moves.
import * as THREE from "three";
import { isTheirs } from "./keys";
import type { Triple } from "./manifest";
import type { Orbit } from "./orbit";
import type { SceneInfo } from "./scene_view";
import { scaleOf } from "./view_camera";

const EASE_SECONDS = 0.12; // after which about two thirds of a change of velocity are reached
const SPEED = 0.5; // of the scene's scale, per second
const FASTER = 4; // with Shift
const LONGEST_STEP = 0.25; // seconds, of a page that was not drawn for a while
const REST = 0.01; // of the speed; a slower camera stands

/** To the right, up along the scene's vertical, ahead. */
const DIRECTIONS: Record<string, Triple> = {
  w: [0, 0, 1],
  s: [0, 0, -1],
  a: [-1, 0, 0],
  d: [1, 0, 0],
  q: [0, -1, 0],
  e: [0, 1, 0],
};

/** Velocity and way after a time in which the same velocity was wanted. */
export function eased(velocity: THREE.Vector3, wanted: THREE.Vector3, seconds: number) {
  const left = Math.exp(-seconds / EASE_SECONDS); // of the difference
  const difference = velocity.clone().sub(wanted);
  return {
    velocity: wanted.clone().addScaledVector(difference, left),
    way: wanted
      .clone()
      .multiplyScalar(seconds)
      .addScaledVector(difference, EASE_SECONDS * (1 - left)),
  };
}

/** World units a second. */
export function speedOf(info: SceneInfo): number {
  return SPEED * scaleOf(info);
}

export class Flight {
  private readonly held = new Set<string>();
  private readonly up: THREE.Vector3;
  private readonly speed: number;
  private velocity = new THREE.Vector3();
  private last = 0; // seconds, of the step before
  private fast = false;

  /** `wall`: seconds. */
  constructor(
    private readonly orbit: Orbit,
    info: SceneInfo,
    private readonly wall: () => number,
  ) {
    this.up = new THREE.Vector3(...info.up).normalize();
    this.speed = speedOf(info);
    addEventListener("keydown", (event) => this.press(event));
    addEventListener("keyup", (event) => this.release(event));
    addEventListener("blur", () => this.held.clear());
  }

  get on(): boolean {
    return this.orbit.flies;
  }

  switch(on: boolean): void {
    this.halt();
    this.orbit.flies = on;
  }

  /** Stands at once; keys that are held count once they are pressed again. */
  halt(): void {
    this.held.clear();
    this.velocity.set(0, 0, 0);
  }

  private press(event: KeyboardEvent): void {
    this.fast = event.shiftKey;
    // systems keep the release of a key to themselves while one of these is down
    if (event.ctrlKey || event.metaKey || event.altKey) return this.held.clear();
    const key = event.key.toLowerCase();
    if (!this.on || event.repeat || !(key in DIRECTIONS) || isTheirs(event.target, key)) return;
    if (document.querySelector("dialog[open]") === null) this.held.add(key);
  }

  private release(event: KeyboardEvent): void {
    this.fast = event.shiftKey;
    this.held.delete(event.key.toLowerCase());
  }

  /** World units a second. */
  private wanted(): THREE.Vector3 {
    const [right, up, ahead] = [0, 1, 2].map((axis) =>
      [...this.held].reduce((sum, key) => sum + DIRECTIONS[key][axis], 0),
    );
    const speed = this.speed * (this.fast ? FASTER : 1);
    return new THREE.Vector3(right, 0, ahead)
      .applyQuaternion(this.orbit.pose.rotation)
      .addScaledVector(this.up, up)
      .clampLength(0, 1)
      .multiplyScalar(speed);
  }

  /** To be called before each image. */
  step(): void {
    const now = this.wall();
    const seconds = Math.min(LONGEST_STEP, now - this.last);
    this.last = now;
    if (this.held.size === 0 && this.velocity.length() < REST * this.speed) {
      this.velocity.set(0, 0, 0);
      return;
    }
    const { velocity, way } = eased(this.velocity, this.wanted(), seconds);
    this.velocity = velocity;
    this.orbit.shift(way);
  }
}
