// Canvas, three.js and Spark, set up so that splats look as they were trained: order by z, float32
// centres, the file's filter and cut-offs, exact pinhole intrinsics.
import { SparkRenderer, type SplatGenerator } from "@sparkjsdev/spark";
import * as THREE from "three";
import type { SplatRules, Triple } from "./manifest";
import { PlayerError } from "./player_error";
import type { SceneInfo, ViewCamera } from "./scene_view";
import { lensScale } from "./view_camera";
import { Headset } from "./xr";

const MAX_PIXEL_RADIUS = 8192; // of a splat: no limit in practice, as in the program's renderer
const FAR_TO_NEAR = 1e5;

/** Half turn about x: from axes right, down, forward to right, up, backward. */
const RUB_FROM_RDF = new THREE.Quaternion(1, 0, 0, 0);

export class Stage {
  readonly scene = new THREE.Scene();
  /** World units; nothing nearer is drawn. */
  near = 0.2;
  private readonly camera = new THREE.PerspectiveCamera();
  private readonly renderer: THREE.WebGLRenderer;
  readonly headset: Headset;
  private readonly spark: SparkRenderer;
  private size = { width: 1, height: 1 }; // CSS pixels

  /** `onDirty`: the image on the screen is outdated (a new depth order has arrived). */
  constructor(
    canvas: HTMLCanvasElement,
    private readonly view: ViewCamera,
    onDirty: () => void,
  ) {
    const context = canvas.getContext("webgl2", {
      alpha: false,
      antialias: false,
      powerPreference: "high-performance",
    });
    if (context === null)
      throw new PlayerError(
        "this browser offers no WebGL2: use a current Chrome, Firefox, Edge or Safari, and " +
          "switch on graphics acceleration in its settings",
        "device",
      );
    this.renderer = new THREE.WebGLRenderer({ canvas, context, antialias: false });
    this.headset = new Headset(this.renderer);
    this.spark = new SparkRenderer({
      renderer: this.renderer,
      onDirty,
      accumExtSplats: true,
      sortRadial: false,
      enableLod: false,
      maxPixelRadius: MAX_PIXEL_RADIUS,
    });
    this.scene.add(this.spark);
    this.camera.matrixAutoUpdate = false;
  }

  setRules(rules: SplatRules): void {
    this.spark.preBlurAmount = rules.compensated ? 0 : rules.dilation;
    this.spark.blurAmount = rules.compensated ? rules.dilation : 0;
    this.spark.maxStdDev = rules.cutoffSigma;
    this.spark.minAlpha = rules.cutoffAlpha;
  }

  /** sRGB, 0 to 255 */
  setBackground([r, g, b]: Triple): void {
    const colour = new THREE.Color().setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace);
    this.renderer.setClearColor(colour, 1);
  }

  resize(width: number, height: number, dpr: number): void {
    if (this.headset.on) return; // the headset has a size of its kind
    this.size = { width: Math.max(1, width), height: Math.max(1, height) };
    this.renderer.setPixelRatio(dpr);
    this.renderer.setSize(this.size.width, this.size.height, false);
  }

  /** The rig's view, as large as fits, in the window's middle; what is around is seen too. */
  private applyCamera(): void {
    const { position, rotation, lens, whole } = this.view;
    const { width, height } = this.size;
    const scale = lensScale(lens, whole, width, height);
    const fx = lens.fx * scale;
    const fy = lens.fy * scale;
    const cx = (width - lens.width * scale) / 2 + lens.cx * scale;
    const cy = (height - lens.height * scale) / 2 + lens.cy * scale;
    const [near, far] = [this.near, this.near * FAR_TO_NEAR];
    const z = (far + near) / (near - far);
    const w = (2 * far * near) / (near - far);
    // rows; x_ndc = 2 x_pixel / width − 1, y_ndc = 1 − 2 y_pixel / height
    this.camera.projectionMatrix.set(
      ...([(2 * fx) / width, 0, 1 - (2 * cx) / width, 0] as const),
      ...([0, (2 * fy) / height, (2 * cy) / height - 1, 0] as const),
      ...([0, 0, z, w] as const),
      ...([0, 0, -1, 0] as const),
    );
    this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
    const [qw, qx, qy, qz] = rotation;
    this.camera.position.set(...position);
    this.camera.quaternion.set(qx, qy, qz, qw).normalize().multiply(RUB_FROM_RDF);
    this.camera.updateMatrix();
    this.camera.updateMatrixWorld(true);
  }

  /** From the person's eyes instead of the page's camera, until `onEnd`. */
  enterVr(info: SceneInfo, onFrame: () => void, onEnd: () => void): Promise<void> {
    return this.headset.start(info, [this.near, this.near * FAR_TO_NEAR], onFrame, onEnd);
  }

  draw(): void {
    if (this.headset.on) return this.renderer.render(this.scene, this.headset.camera);
    this.applyCamera();
    this.renderer.render(this.scene, this.camera);
  }

  /** Whether the depth order on the screen is that of the last draw. */
  get sorted(): boolean {
    const { sorting, sortDirty, display, current } = this.spark;
    return !sorting && !sortDirty && display === current;
  }

  /** What is drawn now, before the browser takes it from the canvas. */
  image(): Promise<Blob | null> {
    this.draw();
    return new Promise((resolve) => this.renderer.domElement.toBlob(resolve, "image/png"));
  }

  /** Waits until the card has done what it was told. */
  finish(): void {
    this.renderer.getContext().finish();
  }

  add(splats: SplatGenerator): void {
    this.scene.add(splats);
  }

  dispose(): void {
    this.spark.dispose();
    this.renderer.dispose();
  }
}
