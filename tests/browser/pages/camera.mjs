// The camera and messages that the pages of all players share.

/** Degrees of a pinhole camera's height. */
export function verticalFov(camera) {
  return 2 * Math.atan(camera.height / (2 * camera.fy)) * 180 / Math.PI;
}

/** Draws `count` times, with a pause for the workers that sort. */
export async function frames(count, draw) {
  for (let i = 0; i < count; ++i) {
    await new Promise((next) => requestAnimationFrame(next));
    draw();
    await new Promise((next) => setTimeout(next, 15));
  }
}
