// Plays scene.t4d (or ?scene=ADDRESS) from the view of its first camera; the mouse turns around it.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { SparkRenderer } from "@sparkjsdev/spark";
import { loadTessera4d, sparkOptions } from "tessera4d-loader";

const line = document.querySelector("p");
const renderer = new THREE.WebGLRenderer({ antialias: false });
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
const spark = new SparkRenderer({ renderer, ...sparkOptions });
scene.add(spark);
const camera = new THREE.PerspectiveCamera(50, 1, 0.05, 1000);
const controls = new OrbitControls(camera, renderer.domElement);

addEventListener("resize", resize);
function resize() {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}

/** Captures have +y down; three.js has it up. */
function standUpright(tessera) {
  tessera.quaternion.setFromUnitVectors(tessera.upwards.clone().normalize(), new THREE.Vector3(0, 1, 0));
  tessera.updateMatrixWorld();
}

function lookFromFirstCamera(tessera) {
  const centre = tessera.bounds?.getCenter(new THREE.Vector3()) ?? new THREE.Vector3();
  controls.target.copy(tessera.localToWorld(centre));
  const first = tessera.cameras[0];
  const place = first ? new THREE.Vector3(...first.position) : new THREE.Vector3(0, 0, -4);
  camera.position.copy(tessera.localToWorld(place));
  controls.update();
}

try {
  const address = new URLSearchParams(location.search).get("scene") ?? "scene.t4d";
  const tessera = await loadTessera4d(address);
  tessera.configure(spark);
  scene.background = tessera.background;
  scene.add(tessera);
  standUpright(tessera);
  lookFromFirstCamera(tessera);
  resize();
  const start = performance.now();
  renderer.setAnimationLoop(() => {
    controls.update();
    const seconds = (performance.now() - start) / 1000;
    tessera.update(tessera.duration > 0 ? seconds % tessera.duration : 0, camera);
    line.textContent = tessera.trouble ?? (tessera.waiting ? "Loading" : "");
    renderer.render(scene, camera);
  });
  globalThis.example = { tessera, camera, controls, renderer, scene, spark }; // for the console
} catch (error) {
  line.textContent = error.message;
}
