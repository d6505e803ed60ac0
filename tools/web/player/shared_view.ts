// A free view as a word of the address, px,py,pz,qw,qx,qy,qz,fov, and back: position in world
// units, rotation of the camera's axes (right, down, forward) into the world, vertical field of
// view in degrees.
import * as THREE from "three";
import type { Lens, SceneInfo, ViewCamera } from "./scene_view";
import { homePose, poseFrom, type Pose } from "./view_camera";

const DIGITS = 6; // significant ones
const VALUES = 8;
const DEGREES = 180 / Math.PI;

function fovOf({ fy, height }: Lens): number {
  return 2 * Math.atan(height / 2 / fy) * DEGREES;
}

/** The lens of the first view, made longer or shorter. */
function lensOf(fov: number, plain: Lens): Lens {
  const scale = plain.height / 2 / Math.tan(fov / 2 / DEGREES) / plain.fy;
  return { ...plain, fx: plain.fx * scale, fy: plain.fy * scale };
}

export function viewWord({ position, rotation, lens }: ViewCamera): string {
  const values = [...position, ...rotation, fovOf(lens)];
  return values.map((value) => String(Number(value.toPrecision(DIGITS)))).join(",");
}

/** null: the word is no view. */
export function poseOfWord(word: string, info: SceneInfo): Pose | null {
  const parts = word.split(",");
  const values = parts.map(Number);
  if (values.length !== VALUES || parts.some((part) => part.trim() === "")) return null;
  if (!values.every(Number.isFinite)) return null;
  const [px, py, pz, qw, qx, qy, qz, fov] = values;
  const rotation = new THREE.Quaternion(qx, qy, qz, qw);
  if (!(rotation.length() > 0.1) || !(fov >= 1 && fov <= 170)) return null;
  const lens = lensOf(fov, homePose(info).lens);
  return poseFrom(new THREE.Vector3(px, py, pz), rotation.normalize(), lens, info);
}
