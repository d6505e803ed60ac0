// Moves the camera by pointer, wheel and touch: one finger or left button turns, two fingers or
// right button pan, pinch or wheel changes the distance. The state represents any pose, roll
// included, so that the view does not jump when it leaves a camera of the rig.
import * as THREE from "three";
import type { Quaternion, Triple } from "./manifest";
import type { Lens, ViewCamera } from "./scene_view";
import { lensScale, type Pose } from "./view_camera";

const TURN = Math.PI; // radians for a drag along the shorter side of the window
const POLE = 0.05; // radians that remain between the viewing direction and `up`
const WHEEL = 0.0015; // of ln distance, per pixel of wheel
const NEAREST = 1e-3; // of the distance that the last pose had, and
const FARTHEST = 50;

export class Orbit {
  private readonly focus = new THREE.Vector3();
  private readonly rotation = new THREE.Quaternion();
  private distance = 1;
  private reach = 1;
  private lens: Lens;
  private readonly fingers = new Map<number, { x: number; y: number }>();
  /** Whether drags look around from where the camera is, instead of turning about the focus. */
  flies = false;
  /** Told when the person moves the camera away from the pose it was given. */
  onMove: () => void = () => {};
  /** Where the person may move the camera: a pose → itself, or the nearest one that is allowed. */
  limit: (pose: Pose) => Pose = (pose) => pose;
  /** Told of a double click or a double tap, CSS pixels of the surface. */
  onFocus: (point: [number, number]) => void = () => {};

  constructor(
    private readonly surface: HTMLElement,
    private readonly camera: ViewCamera,
    private readonly up: THREE.Vector3,
  ) {
    this.lens = camera.lens;
    surface.addEventListener("pointerdown", (event) => this.press(event));
    surface.addEventListener("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"] as const)
      surface.addEventListener(name, (event) => this.fingers.delete(event.pointerId));
    surface.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    surface.addEventListener("dblclick", (event) => this.onFocus([event.offsetX, event.offsetY]));
    surface.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  get pose(): Pose {
    const [position, rotation] = [new THREE.Vector3(...this.camera.position), this.rotation.clone()];
    return { position, rotation, distance: this.distance, lens: this.lens };
  }

  setPose(pose: Pose): void {
    const forward = new THREE.Vector3(0, 0, 1).applyQuaternion(pose.rotation);
    this.rotation.copy(pose.rotation);
    this.distance = this.reach = pose.distance;
    this.focus.copy(pose.position).addScaledVector(forward, pose.distance);
    this.lens = pose.lens;
    this.apply(pose.position);
  }

  /** `exact`: the position itself, where it is known. */
  private apply(exact?: THREE.Vector3): void {
    const forward = new THREE.Vector3(0, 0, 1).applyQuaternion(this.rotation);
    const position = exact ?? this.focus.clone().addScaledVector(forward, -this.distance);
    this.camera.position = position.toArray() as Triple;
    const { x, y, z, w } = this.rotation;
    this.camera.rotation = [w, x, y, z] as Quaternion;
    this.camera.lens = this.lens;
    ++this.camera.version;
  }

  /** Moves the camera and what it turns about, world units. */
  shift(by: THREE.Vector3): void {
    this.focus.add(by);
    this.moved();
  }

  private moved(): void {
    this.apply();
    const { position, rotation, distance } = this.limit(this.pose);
    this.rotation.copy(rotation);
    this.distance = distance;
    this.focus.set(0, 0, distance).applyQuaternion(rotation).add(position);
    this.apply();
    this.onMove();
  }

  private press(event: PointerEvent): void {
    this.surface.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  private drag(event: PointerEvent): void {
    const last = this.fingers.get(event.pointerId);
    if (last === undefined) return;
    const before = this.spread();
    const dx = event.clientX - last.x;
    const dy = event.clientY - last.y;
    if (dx === 0 && dy === 0) return;
    this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (this.fingers.size > 1) {
      const share = 1 / this.fingers.size;
      this.pan(dx * share, dy * share);
      const after = this.spread();
      if (before > 0 && after > 0) this.zoom(before / after);
    } else if (event.buttons & 6 || event.shiftKey || event.ctrlKey || event.metaKey) {
      this.pan(dx, dy);
    } else {
      this.turn(dx, dy);
    }
    this.moved();
  }

  /** Distance of the first two fingers, pixels; 0 with fewer. */
  private spread(): number {
    const [a, b] = this.fingers.values();
    return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    this.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * lines * WHEEL))));
    this.moved();
  }

  private zoom(factor: number): void {
    if (this.flies) {
      const ahead = new THREE.Vector3(0, 0, this.distance).applyQuaternion(this.rotation);
      this.focus.addScaledVector(ahead, 1 - factor);
      return;
    }
    const distance = this.distance * factor;
    this.distance = Math.min(FARTHEST * this.reach, Math.max(NEAREST * this.reach, distance));
  }

  /** Focal length on the surface, CSS pixels. */
  private get focal(): number {
    const { clientWidth, clientHeight } = this.surface;
    return this.lens.fx * lensScale(this.lens, this.camera.whole, clientWidth, clientHeight);
  }

  private pan(dx: number, dy: number): void {
    const units = this.distance / this.focal; // world units a pixel, at the focus
    const shift = new THREE.Vector3(-dx * units, -dy * units, 0).applyQuaternion(this.rotation);
    this.focus.add(shift);
  }

  private turn(dx: number, dy: number): void {
    const { clientWidth, clientHeight } = this.surface;
    // radians a pixel; in flight what is seen follows the pointer
    const rate = this.flies ? -1 / this.focal : TURN / Math.min(clientWidth, clientHeight);
    const right = new THREE.Vector3(1, 0, 0).applyQuaternion(this.rotation);
    const forward = new THREE.Vector3(0, 0, 1).applyQuaternion(this.rotation);
    const tilt = forward.angleTo(this.up); // 0: straight up
    // turning by a positive angle about `right` (axes right, down, forward) looks up
    const wanted = -dy * rate;
    const [lowest, highest] = [tilt - (Math.PI - POLE), tilt - POLE];
    const held =
      wanted > 0 ? Math.max(0, Math.min(wanted, highest)) : Math.min(0, Math.max(wanted, lowest));
    this.rotation.premultiply(new THREE.Quaternion().setFromAxisAngle(right, held));
    this.rotation.premultiply(new THREE.Quaternion().setFromAxisAngle(this.up, -dx * rate));
    this.rotation.normalize();
    if (!this.flies) return;
    this.focus.set(0, 0, this.distance).applyQuaternion(this.rotation);
    this.focus.add(new THREE.Vector3(...this.camera.position));
  }
}
