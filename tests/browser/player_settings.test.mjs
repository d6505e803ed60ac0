// The settings of the player's page, and the limits that keep the view within the region covered by
// the cameras.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {differing, expectClean, openPage, readPng} from './harness.mjs';
import {playerModules} from './player_modules.mjs';
import {pageOfModel} from './player_page.mjs';

const {SeenBounds, poseOfWord, rigPose, settingsOf} =
    await playerModules('seen_bounds', 'settings', 'shared_view', 'view_camera');
const site = pageOfModel();

/** Cameras on a level arc before the middle, from −30° to 30°, 4 units away; up is −y. */
function rigOf(angles) {
  const cameras = angles.map((degrees, i) => {
    const a = degrees * Math.PI / 180;
    const [half, position] = [-a / 2, [4 * Math.sin(a), 0, -4 * Math.cos(a)]];
    return {name: `cam${i}`, position, rotation: [Math.cos(half), 0, Math.sin(half), 0],
            width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240};
  });
  return {cameras, bounds: {min: [-2, -2, -2], max: [2, 2, 2]}, up: [0, -1, 0]};
}
/** A view of the middle from an angle, a height and a distance. */
function poseAt(info, degrees, distance, height = 0) {
  const a = degrees * Math.PI / 180, h = height * Math.PI / 180;
  const y = -distance * Math.sin(h), flat = distance * Math.cos(h);
  const q = [Math.cos(-a / 2), Math.sin(-a / 2)], p = [Math.cos(-h / 2), Math.sin(-h / 2)];
  // about the vertical axis after the horizontal one
  const rotation = [q[0] * p[0], q[0] * p[1], q[1] * p[0], -q[1] * p[1]];
  return poseOfWord([flat * Math.sin(a), y, -flat * Math.cos(a), ...rotation, 50].join(), info);
}
const anglesOf = ({position: {x, y, z}}) => {
  const distance = Math.hypot(x, y, z);
  return [Math.atan2(x, -z), Math.asin(-y / distance)].map((a) => a * 180 / Math.PI)
      .concat(distance).map((value) => Math.round(value * 1000) / 1000 + 0);  // no −0
};

// Bugs put back: limits without the margin; the far side of a range taken; a ring taken for an arc;
// each seen to fail.
test('views stay within the sides, heights and distances of the cameras', () => {
  const info = rigOf([-30, -10, 10, 30]);
  const bounds = new SeenBounds(info);
  for (const camera of info.cameras) {
    const pose = rigPose(camera, info);
    const kept = bounds.within(pose);
    assert.ok(kept.position.distanceTo(pose.position) < 1e-6, camera.name);
    assert.ok(kept.rotation.angleTo(pose.rotation) < 1e-6, camera.name);
  }
  const within = (...place) => anglesOf(bounds.within(poseAt(info, ...place)));
  assert.deepEqual(within(35, 3), [35, 0, 3]);
  assert.deepEqual(within(60, 4), [40, 0, 4]);
  assert.deepEqual(within(-170, 4), [-40, 0, 4]);
  assert.deepEqual(within(0, 9), [0, 0, 4.6]);
  assert.deepEqual(within(0, 0.5), [0, 0, 1.6]);
  assert.deepEqual(within(0, 4, 45), [0, 10, 4]);
  const kept = bounds.within(poseAt(info, 60, 4));
  const ahead = kept.position.clone().set(0, 0, kept.distance).applyQuaternion(kept.rotation);
  assert.ok(ahead.add(kept.position).length() < 1e-6, 'still turned to the middle');
  const ring = new SeenBounds(rigOf([0, 60, 120, 180, 240, 300]));
  for (const between of [-150, -90, -30, 30, 90, 150])
    assert.deepEqual(anglesOf(ring.within(poseAt(info, between, 4))), [between, 0, 4]);
});

// Bug put back: any number accepted; seen to fail.
test('kept settings of others are left out', () => {
  const plain = {resolution: 1, shDegree: 3, frameRate: 0, background: '', stay: true,
                 numbers: false};
  for (const text of [null, 'null', '[', '{"resolution":40,"shDegree":"2","background":"red","stay":1}'])
    assert.deepEqual(settingsOf(text), plain);
  const kept = {resolution: 0.5, shDegree: 0, frameRate: 15, background: 'ffffff', stay: false,
                numbers: true};
  assert.deepEqual(settingsOf(JSON.stringify(kept)), kept);
});

async function middle(page) {
  await page.evaluate(() => window.tessera.settle());
  return readPng(await page.screenshot({clip: {x: 80, y: 70, width: 480, height: 290}}));
}
const viewOf = async (page) => (await page.evaluate(() => window.tessera.view())).split(',').map(Number);

// Bugs put back: a degree that the shader does not use; a resolution that is not applied; settings
// that are not kept; limits that cannot be switched off; each seen to fail.
test('the panel changes the image, and its settings are stored', async () => {
  const {page, problems} = await openPage(site.browser, {origin: site.origin, width: 640, height: 480});
  const open = async () => {
    await page.goto(`${site.address}?paused&cam=front`);
    await page.waitForFunction(() => window.tessera);
    await page.evaluate(() => window.tessera.settle());
  };
  await open();
  const full = await middle(page);
  const set = async (name, value) => {
    await page.keyboard.press('o');
    if (name === 'stay') await page.locator('#set-stay').setChecked(value);
    else await page.locator(`#set-${name}`).selectOption(value);
    await page.keyboard.press('Escape');
  };
  await set('shDegree', '0');
  const flat = await middle(page);
  assert.ok(differing(full, flat, 4) > 300, `${differing(full, flat, 4)} pixels`);
  await set('shDegree', '3');
  assert.equal(differing(full, await middle(page)), 0);
  await set('background', 'ffffff');
  const white = await page.screenshot({clip: {x: 0, y: 80, width: 20, height: 20}});
  assert.deepEqual([...readPng(white).data.subarray(0, 3)], [255, 255, 255]);
  await set('background', '');
  assert.equal(differing(full, await middle(page)), 0);
  await set('resolution', '0.5');
  assert.equal(await page.evaluate(() => document.getElementById('picture').width), 320);
  await open();
  assert.equal(await page.evaluate(() => document.getElementById('picture').width), 320);
  const zoomedOut = async () => {
    await page.keyboard.press('1');
    await page.evaluate(() => window.tessera.settle());
    await page.mouse.move(300, 200);
    for (let i = 0; i < 4; ++i) await page.mouse.wheel(0, 600);
    await page.waitForTimeout(200);
    return viewOf(page);
  };
  const held = await zoomedOut();
  await set('stay', false);
  const free = await zoomedOut();
  assert.ok(Math.hypot(...free.slice(0, 3)) > 1.5 * Math.hypot(...held.slice(0, 3)),
            `${free} and ${held}`);
  await page.close();
  expectClean(problems);
});
