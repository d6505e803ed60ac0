// Flight through the scene of the player's page: easing that does not depend on the frame rate,
// keys, and limits.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {test} from 'node:test';
import {expectClean, openPage} from './harness.mjs';
import {playerModules} from './player_modules.mjs';
import {pageOfModel} from './player_page.mjs';

const {SeenBounds, eased, poseOfWord, speedOf} =
    await playerModules('seen_bounds', 'fly', 'shared_view');
const site = pageOfModel();

/** Four cameras at 4 units from the middle, to which they look, in a half circle; up is −y. */
const kCameras = [-90, -30, 30, 90].map((degrees, i) => {
  const a = degrees * Math.PI / 180;
  return {name: `cam${i}`, position: [4 * Math.sin(a), 0, -4 * Math.cos(a)],
          rotation: [Math.cos(-a / 2), 0, Math.sin(-a / 2), 0],
          width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240};
});
const kInfo = {cameras: kCameras, bounds: {min: [-1, -1, -1], max: [1, 1, 1]}, up: [0, -1, 0]};
const poseOf = (word) => poseOfWord(word, kInfo);

// Bugs put back: the difference halved for every image; the way as velocity times seconds; each
// seen to fail.
test('a flight is the same at 60 and at 7 images a second', () => {
  const still = poseOf('0,0,0,1,0,0,0,50').position, wanted = still.clone().set(0, 1, 3);
  const flown = (steps) => {
    let state = {velocity: still.clone(), way: still.clone()};
    const place = still.clone();
    for (let i = 0; i < steps; ++i) {
      state = eased(state.velocity, wanted, 0.5 / steps);
      place.add(state.way);
    }
    return {velocity: state.velocity, place};
  };
  const [rough, fine] = [flown(3), flown(30)];
  assert.ok(rough.place.distanceTo(fine.place) < 1e-9, `${rough.place.z} and ${fine.place.z}`);
  assert.ok(rough.velocity.distanceTo(fine.velocity) < 1e-9);
  assert.ok(rough.velocity.distanceTo(wanted) < 0.02 * wanted.length(), 'half a second is enough');
  const begin = eased(still, wanted, 1e-3);
  assert.ok(begin.velocity.length() < 0.02 * wanted.length(), 'it begins slowly');
});

// Bugs put back: a speed in world units whatever the scene's scale; views that are turned to the
// middle; places that are not limited; each seen to fail.
test('speed and limits are those of the rig', () => {
  assert.ok(Math.abs(speedOf(kInfo) - 2) < 1e-9, `${speedOf(kInfo)}`);
  const wide = {...kInfo, cameras: [], bounds: {min: [-30, 0, 0], max: [30, 0, 0]}};
  assert.ok(Math.abs(speedOf(wide) - 15) < 1e-9, `${speedOf(wide)}`);
  const bounds = new SeenBounds(kInfo);
  const aside = poseOf('0,0,-3,0.8,0,0.6,0,50');
  assert.ok(bounds.standing(aside).position.distanceTo(aside.position) < 1e-9);
  const far = poseOf('0,0,-9,0.8,0,0.6,0,50');
  const held = bounds.standing(far);
  assert.ok(Math.abs(held.position.z + 4.6) < 1e-9, `${held.position.z}`);
  assert.ok(held.rotation.angleTo(far.rotation) < 1e-9);
});

/** Opens a page; its image is complete. `stay`: within what the cameras have seen. */
async function open(query, stay) {
  const opened = await openPage(site.browser, {origin: site.origin, width: 640, height: 480});
  await opened.page.addInitScript((kept) => {
    localStorage.setItem('tessera-settings', JSON.stringify({stay: kept}));
  }, stay);
  await opened.page.goto(`${site.address}?paused&${query}`);
  await opened.page.waitForFunction(() => window.tessera);
  await opened.page.evaluate(() => window.tessera.settle());
  return opened;
}
const wordOf = (page) => page.evaluate(() => window.tessera.view());
const viewOf = async (page) => (await wordOf(page)).split(',').map(Number);
const distance = (a, b) => Math.hypot(...[0, 1, 2].map((k) => a[k] - b[k]));
const turn = (a, b) =>
    2 * Math.acos(Math.min(1, Math.abs([3, 4, 5, 6].reduce((sum, k) => sum + a[k] * b[k], 0))));
/** The view once it stands. */
async function standing(page) {
  for (let last = '', round = 0; round < 100; ++round) {
    const word = await wordOf(page);
    if (word === last) return viewOf(page);
    last = word;
    await page.evaluate(() => new Promise((resolve) => {  // two steps of the page, however slow
      requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(resolve, 50)));
    }));
  }
  assert.fail('the camera does not come to rest');
}
async function hold(page, ms, ...keys) {
  for (const key of keys) await page.keyboard.down(key);
  await page.waitForTimeout(ms);
  for (const key of keys) await page.keyboard.up(key);
  await standing(page);
}
/** Holds keys for eight images and at least 0.4 s; world units a second of the last four. */
async function flown(page, ...keys) {
  for (const key of keys) await page.keyboard.down(key);
  const speed = await page.evaluate(() => new Promise((resolve) => {
    const seen = [];
    const next = () => {
      const place = window.tessera.view().split(',').slice(0, 3).map(Number);
      seen.push({place, at: performance.now() / 1000});
      if (seen.length < 8 || seen.at(-1).at - seen[0].at < 0.4) return requestAnimationFrame(next);
      const [a, b] = [seen.at(-5), seen.at(-1)];
      return resolve(Math.hypot(...a.place.map((v, k) => v - b.place[k])) / (b.at - a.at));
    };
    requestAnimationFrame(next);
  }));
  for (const key of keys) await page.keyboard.up(key);
  await standing(page);
  return speed;
}
/** How far a point lies ahead of a view, to its right and below it. */
function seenFrom([px, py, pz, w, x, y, z], [ax, ay, az]) {
  const d = [ax - px, ay - py, az - pz];
  const rows = [[1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]];
  const [right, down, ahead] = rows.map((row) => row.reduce((sum, r, k) => sum + r * d[k], 0));
  return {right, down, ahead};
}

// Bugs put back: keys that move without flight; W along the vertical; D to the left; Q up; no
// Shift; a free view that is not written into the address; each seen to fail.
test('keys move the camera in flight alone, and the address has the view', async () => {
  const {page, problems} = await open('cam=front', false);
  const start = await viewOf(page);
  await hold(page, 200, 'w');
  assert.deepEqual(await viewOf(page), start);
  await page.keyboard.press('v');
  assert.ok(await page.locator('#notice').isVisible());
  const {up} = JSON.parse(readFileSync(join(site.folder, 'page', 'manifest.json')));
  const seen = {};
  for (const key of ['w', 'd', 'q']) {
    const before = await viewOf(page);
    const speed = await flown(page, key);
    const after = await viewOf(page);
    assert.ok(turn(before, after) < 1e-3);
    seen[key] = {...seenFrom(before, after), speed, way: distance(before, after),
                 up: up.reduce((sum, u, k) => sum + u * (after[k] - before[k]), 0)};
  }
  assert.ok(seen.w.ahead > 0.2 && seen.w.ahead > 0.999 * seen.w.way, JSON.stringify(seen.w));
  assert.ok(seen.d.right > 0.2 && seen.d.right > 0.999 * seen.d.way, JSON.stringify(seen.d));
  assert.ok(seen.q.up < -0.2 && -seen.q.up > 0.999 * seen.q.way, JSON.stringify(seen.q));
  assert.equal(await page.locator('#camera').inputValue(), '-1');
  await page.waitForURL(/view=/);
  const fast = await flown(page, 'Shift', 'S');
  assert.ok(fast > 2 * seen.w.speed, `Shift is faster: ${fast} and ${seen.w.speed}`);
  await page.keyboard.press('1');
  await page.evaluate(() => window.tessera.settle());
  assert.ok(distance(start, await viewOf(page)) < 1e-6, 'numbers are cameras still');
  await page.close();
  expectClean(problems);
});

// Bugs put back: no listener of blur; keys of a dialog and of a list taken; keys with Ctrl taken;
// each seen to fail.
test('no key stays down when the window loses focus, and those of dialogs are left alone',
     async () => {
  const {page, problems} = await open('cam=front', false);
  await page.keyboard.press('v');
  const still = await wordOf(page);
  await page.keyboard.down('w');
  await page.waitForFunction((word) => window.tessera.view() !== word, still);
  await page.evaluate(() => dispatchEvent(new Event('blur')));
  const stands = await standing(page);
  await page.keyboard.up('w');
  await page.keyboard.press('?');
  await hold(page, 200, 's');
  assert.deepEqual(await viewOf(page), stands, 'in a dialog');
  await page.keyboard.press('Escape');
  await page.locator('#rate').focus();
  await hold(page, 200, 's');
  assert.deepEqual(await viewOf(page), stands, 'in a list');
  await page.locator('canvas').focus();
  await hold(page, 200, 'Control', 's');
  assert.deepEqual(await viewOf(page), stands, 'with Ctrl');
  await flown(page, 's');
  assert.ok(distance(stands, await viewOf(page)) > 0.1);
  await page.close();
  expectClean(problems);
});

async function dragBy(page, dx, dy) {
  await page.mouse.move(300, 200);
  await page.mouse.down();
  await page.mouse.move(300 + dx, 200 + dy, {steps: 4});
  await page.mouse.up();
}

// Bugs put back: a drag about the focus; a drag the other way round; limits that do not hold in
// flight; orbit that keeps a view far from its limits; each seen to fail.
test('a drag looks around in place, and the cameras limit the flight', async () => {
  const {page, problems} = await open('cam=front', true);
  const start = await viewOf(page);
  await page.keyboard.press('o');
  await page.locator('#set-fly').check();
  await page.keyboard.press('Escape');
  await dragBy(page, 160, 0);
  const turned = await viewOf(page);
  assert.ok(distance(start, turned) < 1e-4, `${start} and ${turned}`);
  assert.ok(turn(start, turned) > 0.2, `${turn(start, turned)}`);
  const middle = [0, 1, 2].map((k) => start[k] / 2);
  assert.ok(seenFrom(turned, middle).right > seenFrom(start, middle).right, 'what is seen follows');
  await dragBy(page, -160, 0);
  await hold(page, 4000, 'w', 'Shift');
  const reached = Math.hypot(...(await viewOf(page)).slice(0, 3));
  // 0.4 of the least distance of a camera to 1.15 of the largest, from about the middle
  assert.ok(reached > 1.6 && reached < 5.6, `${reached}`);
  const ahead = async () => seenFrom(await viewOf(page), [0, 0, 0]).ahead;
  for (let i = 0; i < 8 && await ahead() > 0; ++i) await dragBy(page, 250, 0);
  assert.ok(await ahead() <= 0, 'away from the scene');
  await page.keyboard.press('v');
  assert.equal(await page.locator('#set-fly').isChecked(), false);
  await page.evaluate(() => window.tessera.settle());
  assert.ok(await ahead() > 1, 'orbit looks at the scene again');
  await page.close();
  expectClean(problems);
});
