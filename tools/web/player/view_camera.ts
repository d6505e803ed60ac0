// Initial views: those of the rig, exactly as recorded, and one that shows the whole scene where
// there is no rig.
import * as THREE from "three";
import type { Bounds, Camera, Triple } from "./manifest";
import type { Ray } from "./pick";
import type { Lens, SceneInfo, ViewCamera } from "./scene_view";

export interface Pose {
  position: THREE.Vector3;
  rotation: THREE.Quaternion; // camera axes (right, down, forward) into the world
  /** From the camera to what it turns about, world units. */
  distance: number;
  lens: Lens;
}

/** About 50 degrees both ways. */
const PLAIN_LENS: Lens = { fx: 1072, fy: 1072, cx: 500, cy: 500, width: 1000, height: 1000 };
const MARGIN = 1.15; // of the whole scene, around it
const SAME = 1e-6; // world units, radians, share of the width
const PARALLEL = 1e-4; // least determinant of the axes' normal equations, per camera³

export function sizeOf(bounds: Bounds | null): number {
  if (bounds === null) return 1;
  const [low, high] = [new THREE.Vector3(...bounds.min), new THREE.Vector3(...bounds.max)];
  return Math.max(low.distanceTo(high) / 2, 1e-6);
}

function centreOf(bounds: Bounds | null): THREE.Vector3 {
  if (bounds === null) return new THREE.Vector3();
  return new THREE.Vector3(...bounds.min).add(new THREE.Vector3(...bounds.max)).multiplyScalar(0.5);
}

function rotationOf(camera: Camera): THREE.Quaternion {
  const [w, x, y, z] = camera.rotation;
  return new THREE.Quaternion(x, y, z, w).normalize();
}

/** Whether the two see the same; the camera of a test image has another name than that of the rig. */
export function isSameView(one: Camera, other: Camera): boolean {
  const apart = new THREE.Vector3(...one.position).distanceTo(new THREE.Vector3(...other.position));
  const turned = rotationOf(one).angleTo(rotationOf(other));
  const lens = one.fx / one.width - other.fx / other.width;
  return [apart, turned, Math.abs(lens)].every((difference) => difference < SAME);
}

/** The point nearest to all viewing axes; null where they run side by side. */
function focusOf(cameras: Camera[]): THREE.Vector3 | null {
  // Σ (1 − d dᵀ) x = Σ (1 − d dᵀ) p
  const normal = new Array<number>(9).fill(0);
  const right = new THREE.Vector3();
  for (const camera of cameras) {
    const d = new THREE.Vector3(0, 0, 1).applyQuaternion(rotationOf(camera)).toArray();
    const p = camera.position;
    const along = d[0] * p[0] + d[1] * p[1] + d[2] * p[2];
    for (let i = 0; i < 3; ++i) {
      right.setComponent(i, right.getComponent(i) + p[i] - d[i] * along);
      for (let k = 0; k < 3; ++k) normal[3 * i + k] += Number(i === k) - d[i] * d[k];
    }
  }
  const matrix = new THREE.Matrix3().fromArray(normal); // symmetric
  if (!(matrix.determinant() > PARALLEL * cameras.length ** 3)) return null;
  return right.applyMatrix3(matrix.invert());
}

/** What all cameras of the rig look at; the middle of the scene where they have no such point. */
export function focusOfRig(info: SceneInfo): THREE.Vector3 {
  return focusOf(info.cameras) ?? centreOf(info.bounds);
}

/** The mean distance of the rig's cameras from what they look at, or the scene's size. */
export function scaleOf(info: SceneInfo): number {
  const focus = focusOfRig(info);
  const distances = info.cameras.map(({ position }) =>
    focus.distanceTo(new THREE.Vector3(...position)),
  );
  const mean = distances.reduce((sum, distance) => sum + distance, 0) / distances.length;
  return mean > 0 ? mean : sizeOf(info.bounds);
}

/** It turns about the point of its axis that is nearest to what all cameras look at. */
export function poseFrom(
  position: THREE.Vector3,
  rotation: THREE.Quaternion,
  lens: Lens,
  info: SceneInfo,
): Pose {
  const forward = new THREE.Vector3(0, 0, 1).applyQuaternion(rotation);
  const along = focusOfRig(info).sub(position).dot(forward);
  const size = sizeOf(info.bounds);
  return { position, rotation, distance: along > 0.05 * size ? along : size, lens };
}

/** The view of a rig's camera, exactly. */
export function rigPose(camera: Camera, info: SceneInfo): Pose {
  const { fx, fy, cx, cy, width, height } = camera;
  const lens = { fx, fy, cx, cy, width, height };
  return poseFrom(new THREE.Vector3(...camera.position), rotationOf(camera), lens, info);
}

/**
 * Pixels of a window for a pixel of the lens, whose image is in its middle: as large as fits. In an
 * upright window the sides of a wide image are cut, half way to one that fills the window, unless it
 * is wanted whole.
 */
export function lensScale(lens: Lens, whole: boolean, width: number, height: number): number {
  const fit = Math.min(width / lens.width, height / lens.height);
  const isUpright = height > width && lens.width > lens.height;
  return isUpright && !whole ? Math.sqrt(fit * (height / lens.height)) : fit;
}

/** Through a point of a window, CSS pixels; the lens fits into it as stage.ts draws it. */
export function rayOf(
  { position, rotation, lens, whole }: ViewCamera,
  width: number,
  height: number,
  [x, y]: [number, number],
): Ray {
  const scale = lensScale(lens, whole, width, height);
  const right = ((x - width / 2) / scale + lens.width / 2 - lens.cx) / lens.fx;
  const down = ((y - height / 2) / scale + lens.height / 2 - lens.cy) / lens.fy;
  const [qw, qx, qy, qz] = rotation;
  const direction = new THREE.Vector3(right, down, 1)
    .applyQuaternion(new THREE.Quaternion(qx, qy, qz, qw))
    .normalize();
  return { origin: new THREE.Vector3(...position), direction };
}

/** The same place and lens, turned to a point at a depth along a ray. */
export function poseTowards(pose: Pose, ray: Ray, depth: number): Pose {
  const forward = new THREE.Vector3(0, 0, 1).applyQuaternion(pose.rotation);
  const turn = new THREE.Quaternion().setFromUnitVectors(forward, ray.direction);
  return { ...pose, rotation: turn.multiply(pose.rotation), distance: depth };
}

/** Camera axes from a viewing direction; `up`: any vector not along it. */
export function lookRotation(forward: THREE.Vector3, up: THREE.Vector3): THREE.Quaternion {
  const z = forward.clone().normalize();
  const x = z.clone().cross(up).normalize();
  const y = z.clone().cross(x);
  return new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().makeBasis(x, y, z));
}

/** All of the scene, from a little above. */
function overviewPose(info: SceneInfo): Pose {
  const up = new THREE.Vector3(...(info.up as Triple)).normalize();
  const axis = Math.abs(up.z) < 0.9 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(0, 1, 0);
  const level = axis.clone().addScaledVector(up, -axis.dot(up)).normalize();
  const forward = level.clone().addScaledVector(up, -0.25).normalize();
  const half = PLAIN_LENS.width / 2 / PLAIN_LENS.fx;
  const distance = (MARGIN * sizeOf(info.bounds)) / Math.sin(Math.atan(half));
  return {
    position: centreOf(info.bounds).addScaledVector(forward, -distance),
    rotation: lookRotation(forward, up),
    distance,
    lens: PLAIN_LENS,
  };
}

/** The view that a scene opens with. */
export function homePose(info: SceneInfo): Pose {
  return info.cameras.length > 0 ? rigPose(info.cameras[0], info) : overviewPose(info);
}
