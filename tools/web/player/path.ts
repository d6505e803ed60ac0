// The path of the camera in automatic play: a closed curve through the cameras of the rig, or one
// turn about the scene where there are too few of them for a curve.
import * as THREE from "three";
import { eased, focusOf, lensBetween, poseBetween } from "./motion";
import type { SceneInfo } from "./scene_view";
import { tourOf } from "./tour";
import { focusOfRig, homePose, lookRotation, rigPose, type Pose } from "./view_camera";

const CAMERA_SECONDS = 3;
const MOST_SECONDS = 40; // of a whole tour
const TURN_SECONDS = 30; // about a scene without a rig
const FEWEST = 3; // cameras of a curve that does not run to and fro
const STEEP = Math.cos(Math.PI / 9); // of the angle to the vertical from which level has no sense
const SAMPLES = 20; // of the curve, a camera
const JOIN_SECONDS = 1.2; // from the view at the start onto the path

export interface CameraPath {
  seconds: number; // once around
  /** `share`: 0 to 1; 1 is where 0 is. */
  poseAt(share: number): Pose;
}

function closed(points: THREE.Vector3[]): THREE.CatmullRomCurve3 {
  const curve = new THREE.CatmullRomCurve3(points, true, "centripetal");
  curve.arcLengthDivisions = SAMPLES * points.length;
  return curve;
}

/** At one speed through all cameras, looking where they look, and level unless they look down. */
function rigPath(info: SceneInfo): CameraPath {
  const places = info.cameras.map(({ position }) => new THREE.Vector3(...position));
  const poses = tourOf(places).map((i) => rigPose(info.cameras[i], info));
  const curve = closed(poses.map(({ position }) => position));
  const targets = closed(poses.map(focusOf));
  const up = new THREE.Vector3(...info.up).normalize();
  const slopeOf = ({ rotation }: Pose) =>
    Math.abs(new THREE.Vector3(0, 0, 1).applyQuaternion(rotation).dot(up));
  const level = poses.every((pose) => slopeOf(pose) < STEEP);
  const poseAt = (share: number): Pose => {
    const t = curve.getUtoTmapping(share - Math.floor(share), 0); // 0: by the share, not a length
    const position = curve.getPoint(t);
    const ahead = targets.getPoint(t).sub(position);
    const leg = Math.floor(t * poses.length) % poses.length;
    const [from, to] = [poses[leg], poses[(leg + 1) % poses.length]];
    const part = (t * poses.length) % 1;
    return {
      position,
      rotation: level
        ? lookRotation(ahead, up)
        : from.rotation.clone().slerp(to.rotation, part),
      distance: ahead.length(),
      lens: lensBetween(from.lens, to.lens, part),
    };
  };
  return { seconds: Math.min(MOST_SECONDS, CAMERA_SECONDS * poses.length), poseAt };
}

/** The first view, turned about the vertical through the middle. */
function turnPath(info: SceneInfo): CameraPath {
  const home = homePose(info);
  const middle = focusOfRig(info);
  const up = new THREE.Vector3(...info.up).normalize();
  const poseAt = (share: number): Pose => {
    const turn = new THREE.Quaternion().setFromAxisAngle(up, 2 * Math.PI * share);
    const offset = home.position.clone().sub(middle).applyQuaternion(turn);
    return { ...home, position: offset.add(middle), rotation: turn.multiply(home.rotation) };
  };
  return { seconds: TURN_SECONDS, poseAt };
}

export function pathOf(info: SceneInfo): CameraPath {
  return info.cameras.length < FEWEST ? turnPath(info) : rigPath(info);
}

/** The share of the path that is nearest to a place. */
function shareNear(path: CameraPath, place: THREE.Vector3): number {
  const count = Math.ceil((SAMPLES * path.seconds) / CAMERA_SECONDS);
  const shares = Array.from({ length: count }, (_, k) => k / count);
  const distances = shares.map((share) => path.poseAt(share).position.distanceTo(place));
  return shares[distances.indexOf(Math.min(...distances))];
}

/** The camera on the path, around and around, from where it is when it starts. */
export class Playback {
  private path: CameraPath | null = null; // made when it is first played
  private run: { from: Pose; share: number; begin: number | null } | null = null;

  /** `wall`: seconds. */
  constructor(
    private readonly info: SceneInfo,
    private readonly setPose: (pose: Pose) => void,
    private readonly wall: () => number,
  ) {}

  get on(): boolean {
    return this.run !== null;
  }

  start(from: Pose): void {
    this.path ??= pathOf(this.info);
    this.run = { from, share: shareNear(this.path, from.position), begin: null };
  }

  stop(): void {
    this.run = null;
  }

  /** To be called before each image. */
  step(): void {
    if (this.run === null || this.path === null) return;
    const { from, share } = this.run;
    this.run.begin ??= this.wall(); // with its first image
    const seconds = this.wall() - this.run.begin;
    // at first slower, so that it begins at rest
    const joined = Math.min(1, seconds / JOIN_SECONDS);
    const way = seconds - JOIN_SECONDS * (joined - joined ** 2 / 2);
    const pose = this.path.poseAt(share + way / this.path.seconds);
    this.setPose(joined < 1 ? poseBetween(from, pose, eased(joined)) : pose);
  }
}
