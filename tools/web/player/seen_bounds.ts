// The views that the cameras of the rig support: around the point that they look at, the range of
// their heights, of their sides and of their distances, each with a margin.
import * as THREE from "three";
import type { SceneInfo } from "./scene_view";
import { focusOfRig, type Pose } from "./view_camera";

const MARGIN = Math.PI / 18; // radians beyond the outermost cameras
const WIDEST_GAP = (2 * Math.PI) / 3; // between two cameras of a ring, seen from its middle
const NEAREST = 0.4; // of the least distance of a camera
const FARTHEST = 1.15; // of the largest one
const PAN = 0.35; // of the mean distance: how far from the middle the view may turn about
const POLE = Math.PI / 2 - 0.05;

interface Range {
  low: number;
  high: number;
}

function clamped(value: number, { low, high }: Range): number {
  return Math.min(high, Math.max(low, value));
}

/** An angle equal to `angle` in the turn that begins at `start`. */
function from(start: number, angle: number): number {
  const turn = 2 * Math.PI;
  return start + ((((angle - start) % turn) + turn) % turn);
}

/** The arc that holds all angles; null where they leave no wide gap. */
function arcOf(angles: number[]): Range | null {
  const sorted = [...angles].sort((a, b) => a - b);
  let gap = 0;
  let start = 0;
  sorted.forEach((angle, i) => {
    const next = sorted[(i + 1) % sorted.length];
    const size = from(angle, next) - angle || 2 * Math.PI; // of a single camera
    if (size > gap) [gap, start] = [size, next];
  });
  return gap < WIDEST_GAP ? null : { low: start, high: start + 2 * Math.PI - gap };
}

export class SeenBounds {
  private readonly focus: THREE.Vector3;
  private readonly axes: { right: THREE.Vector3; ahead: THREE.Vector3; up: THREE.Vector3 };
  private readonly side: Range | null;
  private readonly height: Range;
  private readonly distance: Range;
  private readonly pan: number;

  /** `info`: with at least one camera. */
  constructor(info: SceneInfo) {
    this.focus = focusOfRig(info);
    const up = new THREE.Vector3(...info.up).normalize();
    const other = Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    const ahead = up.clone().cross(other).normalize();
    this.axes = { right: ahead.clone().cross(up), ahead, up };
    const places = info.cameras.map(({ position }) => this.placeOf(new THREE.Vector3(...position)));
    const rangeOf = (values: number[]) => ({ low: Math.min(...values), high: Math.max(...values) });
    const heights = rangeOf(places.map(({ height }) => height));
    const distances = rangeOf(places.map(({ distance }) => distance));
    const side = arcOf(places.map(({ side }) => side));
    this.side = side && { low: side.low - MARGIN, high: side.high + MARGIN };
    this.height = {
      low: Math.max(-POLE, heights.low - MARGIN),
      high: Math.min(POLE, heights.high + MARGIN),
    };
    this.distance = { low: NEAREST * distances.low, high: FARTHEST * distances.high };
    this.pan = (PAN * (distances.low + distances.high)) / 2;
  }

  /** Angles as seen from the focus, radians, and distance from it. */
  private placeOf(position: THREE.Vector3) {
    const offset = position.clone().sub(this.focus);
    const distance = Math.max(offset.length(), 1e-9);
    const { right, ahead, up } = this.axes;
    const height = Math.asin(Math.max(-1, Math.min(1, offset.dot(up) / distance)));
    return { side: Math.atan2(offset.dot(ahead), offset.dot(right)), height, distance };
  }

  /** The nearest of the side's range, the shorter way round. */
  private sideWithin(angle: number): number {
    if (this.side === null) return angle;
    const { low, high } = this.side;
    const inside = from(low, angle);
    if (inside <= high) return inside;
    return inside - high < low + 2 * Math.PI - inside ? high : low;
  }

  /** The place itself where it lies within; else the nearest one. */
  private placeWithin(position: THREE.Vector3): THREE.Vector3 {
    const place = this.placeOf(position);
    const side = this.sideWithin(place.side);
    const height = clamped(place.height, this.height);
    const distance = clamped(place.distance, this.distance);
    const { right, ahead, up } = this.axes;
    return this.focus
      .clone()
      .addScaledVector(right, distance * Math.cos(height) * Math.cos(side))
      .addScaledVector(ahead, distance * Math.cos(height) * Math.sin(side))
      .addScaledVector(up, distance * Math.sin(height));
  }

  /** The same view from a place that lies within; it may look anywhere. */
  standing(pose: Pose): Pose {
    return { ...pose, position: this.placeWithin(pose.position) };
  }

  /** The same view where it lies within; else the nearest one, turned to what it looked at. */
  within(pose: Pose): Pose {
    const forward = new THREE.Vector3(0, 0, 1).applyQuaternion(pose.rotation);
    const target = pose.position.clone().addScaledVector(forward, pose.distance);
    const shift = target.clone().sub(this.focus).clampLength(0, this.pan);
    const pivot = shift.add(this.focus);
    const moved = pose.position.clone().add(pivot).sub(target);
    const position = this.placeWithin(moved);
    const wanted = pivot.clone().sub(position);
    const turn = new THREE.Quaternion().setFromUnitVectors(forward, wanted.clone().normalize());
    return {
      position,
      rotation: turn.multiply(pose.rotation).normalize(),
      distance: wanted.length(),
      lens: pose.lens,
    };
  }
}
