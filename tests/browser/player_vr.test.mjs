// The player's page in a headset, emulated by Meta's WebXR emulator: the place of the scene, begin
// and end of the session, and playback during it.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {test} from 'node:test';
import {differing, expectClean, openPage, packagesFolder, readPng} from './harness.mjs';
import {playerModules} from './player_modules.mjs';
import {pageOfModel} from './player_page.mjs';

const {placeOf, placed, poseOfWord} = await playerModules('xr', 'shared_view');
const site = pageOfModel();

/** Cameras at 6 units from the middle, at heights in degrees, looking at it; up is −y. */
function rigOf(...heights) {
  const cameras = heights.map((degrees, i) => {
    const a = degrees * Math.PI / 180;
    return {name: `cam${i}`, position: [0, -6 * Math.sin(a), -6 * Math.cos(a)],
            rotation: [Math.cos(a / 2), -Math.sin(a / 2), 0, 0],
            width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240};
  });
  return {cameras, bounds: {min: [-1, -1, -1], max: [1, 1, 1]}, up: [0, -1, 0]};
}

// Bugs put back: the scale left away; a place that is tilted as the camera is; a scale that gets
// into the matrix; ahead of a view straight down taken from its axis; each seen to fail.
test('the headset begins at the first view, level, two metres from the middle', () => {
  const info = rigOf(30, -10), place = placeOf(info);
  assert.ok(Math.abs(place.unitsPerMetre - 3) < 1e-6);
  const {position} = poseOfWord('0,0,0,1,0,0,0,50', info);
  const axis = (...v) => position.clone().set(...v).applyQuaternion(place.rotation).toArray()
      .map((value) => Math.round(1e6 * value) / 1e6 + 0);
  assert.deepEqual(axis(0, 1, 0), [0, -1, 0], 'up is up');
  assert.deepEqual(axis(0, 0, -1), [0, 0, 1], 'ahead is where the camera looks, but level');
  const down = placeOf(rigOf(92));
  const ahead = position.clone().set(0, 0, -1).applyQuaternion(down.rotation).toArray();
  assert.ok(Math.abs(ahead[2] - 1) < 1e-6, `${ahead}`);
  // an eye half a metre to the left of the origin; the camera looks along z, with x on its right
  const eye = placed({elements: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -0.5, 0, 0, 1]}, place);
  const [x, y, z] = [12, 13, 14].map((k) => eye.elements[k]);
  const first = info.cameras[0].position;
  assert.ok(Math.hypot(x - first[0] + 1.5, y - first[1], z - first[2]) < 1e-6, `${[x, y, z]}`);
  assert.ok(Math.abs(eye.determinant() - 1) < 1e-6, 'rigid');
});

/** Opens a page whose browser has an emulated headset; the first image is there. */
async function open(query) {
  const opened = await openPage(site.browser, {origin: site.origin, width: 640, height: 480});
  await opened.page.addInitScript({path: join(packagesFolder, 'iwer', 'build', 'iwer.js')});
  await opened.page.addInitScript(() => {
    window.headset = new IWER.XRDevice(IWER.metaQuest3);
    window.headset.installRuntime({forceInstall: true});
    window.headset.stereoEnabled = true;
  });
  await opened.page.goto(`${site.address}?${query}`);
  await opened.page.waitForFunction(() => window.tessera);
  await opened.page.evaluate(() => window.tessera.settle());
  return opened;
}
/** The whole window: in a session both eyes side by side. */
const windowOf = async (page) => readPng(await page.screenshot());
/** The window once it is as `holds` asks, and stands like that for a second. */
async function windowWhere(page, holds, what) {
  for (let round = 0, held = 0; round < 40; ++round) {
    const image = await windowOf(page);
    held = holds(image) ? held + 1 : 0;
    if (held === 3) return image;
    await page.waitForTimeout(500);
  }
  return assert.fail(what);
}
async function enter(page) {
  await page.locator('#vr').click();
  await page.locator('#vr[aria-pressed="true"]').waitFor({state: 'attached'});
}
async function leave(page) {
  await page.evaluate(() => window.headset.activeSession.end());
  await page.locator('#vr[aria-pressed="false"]').waitFor({state: 'attached'});
  await page.mouse.move(300, 200);  // off the button
  await page.evaluate(() => window.tessera.settle());
}
/** Pixels of one half of the window that show the scene. */
function litHalf({width, height, data}, half) {
  let count = 0;
  for (let y = 0; y < height; ++y)
    for (let x = half * width / 2; x < (half + 1) * width / 2; ++x)
      count += Math.max(...data.slice(4 * (y * width + x), 4 * (y * width + x) + 3)) > 60;
  return count;
}

// Bugs put back: a button in browsers without a headset; a session without a loop; the page's
// camera and its depths in the session; eyes that are not put into the world; an end that leaves
// the page as it was drawn for the eyes; each seen to fail.
test('a session shows the scene to both eyes, and the page is as before when it ends', async () => {
  const plain = await openPage(site.browser, {origin: site.origin});
  await plain.page.goto(`${site.address}?paused`);
  await plain.page.waitForFunction(() => window.tessera);
  await plain.page.evaluate(() => window.tessera.settle());
  assert.ok(await plain.page.locator('#vr').isHidden());
  await plain.page.close();
  const {page, problems} = await open('paused&cam=side&t=1.2');
  const before = await windowOf(page);
  const {bounds, splat} = JSON.parse(readFileSync(join(site.folder, 'page', 'manifest.json')));
  const size = Math.hypot(...bounds.max.map((high, k) => high - bounds.min[k]));
  const near = Math.min(splat.near ?? 0.2, 0.01 * size);
  for (let round = 0; round < 2; ++round) {
    await enter(page);
    const eyes = await windowWhere(
        page, (image) => [0, 1].map((half) => litHalf(image, half))
            .every((lit) => lit > 3000 && lit < 30000), 'the scene from outside, for both eyes');
    const depthNear =
        await page.evaluate(() => window.headset.activeSession.renderState.depthNear);
    assert.ok(Math.abs(depthNear / near - 1) < 1e-6, `${depthNear} and ${near}`);
    await page.evaluate(() => {
      window.headset.position.x += 0.4;
      window.headset.quaternion.set(0, 0.26, 0, 0.966);  // 30° to the left
    });
    await windowWhere(page, (image) => differing(eyes, image, 8) > 3000, 'the head moves');
    await page.evaluate(() => {
      window.headset.position.x -= 0.4;
      window.headset.quaternion.set(0, 0, 0, 1);
    });
    await leave(page);
    assert.equal(differing(before, await windowOf(page)), 0, 'the same page again');
  }
  await page.close();
  expectClean(problems);
});

// Bug put back: a session whose images leave the clock alone; seen to fail.
test('time plays on in a session', async () => {
  const {page, problems} = await open('paused&cam=front');
  await enter(page);
  const still = await windowWhere(page, (image) => litHalf(image, 0) > 3000, 'the scene');
  await page.evaluate(() => window.tessera.play());
  await page.waitForFunction(() => window.tessera.time() > 0.5);
  await page.evaluate(() => window.tessera.pause());
  await windowWhere(page, (image) => differing(still, image, 8) > 1000,
                    'what is drawn is of that time');
  await leave(page);
  await page.close();
  expectClean(problems);
});
