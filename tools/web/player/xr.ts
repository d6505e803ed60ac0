// The scene in a headset, by WebXR on three.js's renderer: the session begins at the first view,
// level, in a world in which the cameras of the rig are two metres from their target.
import * as THREE from "three";
import type { SceneInfo } from "./scene_view";
import { homePose, scaleOf } from "./view_camera";

const SCALE_METRES = 2; // that the scene's scale becomes
const LEAST_LEVEL = 0.1; // length of a level direction that still tells one
const ONE = new THREE.Vector3(1, 1, 1);

/** Where the headset's space (metres, y up, looking along −z from its origin) is in the world. */
export interface Place {
  origin: THREE.Vector3; // world units
  rotation: THREE.Quaternion;
  unitsPerMetre: number;
}

export function placeOf(info: SceneInfo): Place {
  const { position, rotation } = homePose(info);
  const up = new THREE.Vector3(...info.up).normalize();
  const level = (x: number, y: number, z: number) =>
    new THREE.Vector3(x, y, z).applyQuaternion(rotation).projectOnPlane(up);
  const ahead = level(0, 0, 1);
  // of a view straight down, the upper edge is ahead
  const back = (ahead.length() > LEAST_LEVEL ? ahead : level(0, -1, 0)).normalize().negate();
  const right = up.clone().cross(back);
  return {
    origin: position,
    rotation: new THREE.Quaternion().setFromRotationMatrix(
      new THREE.Matrix4().makeBasis(right, up, back),
    ),
    unitsPerMetre: scaleOf(info) / SCALE_METRES,
  };
}

/** The pose of an eye in the headset's space → in the world, without the scale. */
export function placed(pose: THREE.Matrix4, place: Place): THREE.Matrix4 {
  const position = new THREE.Vector3()
    .setFromMatrixPosition(pose)
    .multiplyScalar(place.unitsPerMetre)
    .applyQuaternion(place.rotation)
    .add(place.origin);
  const rotation = new THREE.Quaternion().setFromRotationMatrix(pose).premultiply(place.rotation);
  return new THREE.Matrix4().compose(position, rotation, ONE);
}

export async function isVrSupported(): Promise<boolean> {
  try {
    return (await navigator.xr?.isSessionSupported("immersive-vr")) ?? false;
  } catch {
    return false; // a page in a frame that may not use it
  }
}

export class Headset {
  /** What three.js draws with in a session; it takes on what the eyes see. */
  readonly camera = new THREE.PerspectiveCamera();
  private place: Place | null = null;

  constructor(private readonly renderer: THREE.WebGLRenderer) {}

  /** Whether a session is on. */
  get on(): boolean {
    return this.renderer.xr.isPresenting;
  }

  /**
   * To be called at a press of the person. `range`: depths that are drawn, world units; `onFrame`:
   * called for every image of the headset. Resolves when the session has begun.
   */
  async start(
    info: SceneInfo,
    range: [number, number],
    onFrame: () => void,
    onEnd: () => void,
  ): Promise<void> {
    const session = await navigator.xr!.requestSession("immersive-vr");
    const { xr } = this.renderer;
    this.place = placeOf(info);
    [this.camera.near, this.camera.far] = range;
    const ended = () => {
      xr.removeEventListener("sessionend", ended);
      xr.setAnimationLoop(null);
      onEnd();
    };
    xr.addEventListener("sessionend", ended);
    xr.enabled = true;
    xr.setReferenceSpaceType("local");
    xr.setAnimationLoop(onFrame);
    try {
      await xr.setSession(session);
    } catch (error) {
      await session.end();
      throw error;
    }
  }

  end(): void {
    void this.renderer.xr.getSession()?.end();
  }

  /** Puts the eyes of this image into the world; where one is. null: outside of an image. */
  placeEyes(): THREE.Vector3 | null {
    const { xr } = this.renderer;
    const space = xr.getReferenceSpace();
    if (this.place === null || space === null) return null;
    if (!xr.getFrame()?.getViewerPose(space)) return null;
    const head = xr.getCamera();
    for (const camera of [head, ...head.cameras]) {
      camera.matrix.copy(placed(camera.matrix, this.place));
      camera.matrix.decompose(camera.position, camera.quaternion, camera.scale);
    }
    return head.position;
  }
}
