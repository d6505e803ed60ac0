// Camera motions of the player's page: an eased change from view to view, a move to the point of a
// double click, and an immediate change where reduced motion is preferred.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {expectClean, openPage, psnr, readPng} from './harness.mjs';
import {playerModules} from './player_modules.mjs';
import {pageOfModel} from './player_page.mjs';

const {Moves, firstDepth, hitOf, poseBetween, poseOfWord} =
    await playerModules('motion', 'pick', 'shared_view');
const site = pageOfModel();

const kInfo = {cameras: [], bounds: {min: [-1, -1, -1], max: [1, 1, 1]}, up: [0, -1, 0]};
/** Two units before the middle of the scene, and on its right side. */
const kFront = poseOfWord('0,0,-2,1,0,0,0,50', kInfo);
const kSide = poseOfWord(`2,0,0,${Math.SQRT1_2},0,${-Math.SQRT1_2},0,50`, kInfo);

// Bugs put back: positions blended in a straight line; the exact pose not set at the end; motion
// although less is preferred; each seen to fail.
test('a move leads around the scene and ends exactly', () => {
  const half = poseBetween(kFront, kSide, 0.5);
  assert.ok(Math.abs(half.position.length() - 2) < 1e-6, `${half.position.length()}`);
  const wall = {now: 5};
  const set = [];
  const moves = (still) => new Moves((pose) => set.push(pose), () => wall.now, () => still);
  const slow = moves(false);
  slow.start(kFront, kSide);
  wall.now += 0.1;
  slow.step();
  assert.ok(set[0].position.z < -1.8, 'slow at first');
  wall.now += 1;
  slow.step();
  assert.equal(set.at(-1), kSide);
  slow.step();
  assert.equal(set.length, 2);
  moves(true).start(kFront, kSide);
  assert.equal(set.length, 3);
  assert.equal(set.at(-1), kSide);
});

// Bugs put back: the nearest Gaussian taken however faint; Gaussians behind the ray counted; each
// seen to fail.
test('a ray stops at the first opaque surface', () => {
  const vector = (x, y, z) => ({x, y, z});
  const ray = {origin: vector(0, 0, 0), direction: vector(0, 0, 1)};
  const hits = [[0, 0, 5, 0.1, 0.9], [0, 0, 1, 0.1, 0.2], [0, 0, -1, 0.1, 0.9],
                [0, 2, 3, 0.1, 0.9]].map((each) => hitOf(ray, ...each)).filter((hit) => hit);
  assert.deepEqual(hits.map(({depth}) => depth), [5, 1]);
  assert.equal(firstDepth(hits), 5);
  assert.equal(firstDepth([]), null);
});

/** Opens a page; its image is complete. */
async function open(query, more = {}) {
  const opened = await openPage(site.browser, {origin: site.origin, width: 640, height: 480, ...more});
  await opened.page.goto(`${site.address}?paused&${query}`);
  await opened.page.waitForFunction(() => window.tessera);
  await opened.page.evaluate(() => window.tessera.settle());
  return opened;
}
const viewOf = async (page) => (await page.evaluate(() => window.tessera.view())).split(',').map(Number);
const distance = (a, b) => Math.hypot(...[0, 1, 2].map((k) => a[k] - b[k]));

// Bugs put back: the camera set at once; settle() that leaves the move as it is; a drag that the
// move overrules; each seen to fail.
test('cameras are reached by a move, which settle() ends and a drag stops', async () => {
  const {page, problems} = await open('cam=front');
  const front = await viewOf(page);
  const [early, side] = await page.evaluate(async () => {
    window.tessera.camera('side');
    const early = window.tessera.view();
    const settled = window.tessera.settle();
    const late = window.tessera.view();  // before an image that takes longer than the move
    await settled;
    return [early, late].map((word) => word.split(',').map(Number));
  });
  assert.ok(distance(front, side) > 0.5);
  assert.ok(distance(front, early) < 1e-6, 'it begins where it was');
  await page.evaluate(() => window.tessera.camera('front'));
  await page.mouse.move(300, 200);
  await page.mouse.down();
  await page.mouse.move(301, 200);
  await page.mouse.up();
  const stopped = await viewOf(page);
  await page.waitForTimeout(1200);
  assert.ok(distance(stopped, await viewOf(page)) < 1e-6, 'the drag has stopped it');
  await page.close();
  const quiet = await open('cam=front', {reducedMotion: 'reduce'});
  const jumped = await quiet.page.evaluate(() => {
    window.tessera.camera('side');
    return window.tessera.view().split(',').map(Number);
  });
  assert.ok(distance(jumped, side) < 1e-6);
  await quiet.page.close();
  for (const each of [problems, quiet.problems]) expectClean(each);
});

// Bugs put back: the point taken from the window's corner instead of the lens; a focus without the
// turn; each seen to fail.
test('a double click turns to the point that was clicked', async () => {
  const {page, problems} = await open('cam=front');
  const front = await viewOf(page);
  await page.mouse.dblclick(420, 240);
  await page.evaluate(() => window.tessera.settle());
  const turned = await viewOf(page);
  assert.ok(distance(front, turned) < 1e-4, 'from the same place');
  const dot = Math.abs([3, 4, 5, 6].reduce((sum, k) => sum + front[k] * turned[k], 0));
  const fov = front[7] * Math.PI / 180;
  const expected = Math.atan(100 / (240 / Math.tan(fov / 2)));
  assert.ok(Math.abs(2 * Math.acos(Math.min(1, dot)) - expected) < 0.02,
            `${2 * Math.acos(Math.min(1, dot))} of ${expected}`);
  assert.equal(await page.locator('#camera').inputValue(), '-1');
  await page.close();
  expectClean(problems);
});

// Frames come every three seconds here, so the last depth order may still be on its way (37 dB).
// Bug put back: settle() that waits for the time of the last frame; seen to fail (20 dB).
test('settle() waits for a seek of just now, also where frames are slow', async () => {
  const {page, problems} = await open('');
  const shown = async () => readPng(await page.screenshot({style: '.panel { visibility: hidden; }'}));
  const before = await shown();
  await page.evaluate(async () => {
    const request = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (call) => setTimeout(() => request(call), 3000);
    await new Promise((resolve) => setTimeout(resolve, 500));  // the frame asked for before
    window.tessera.seek(2);
    await window.tessera.settle();
  });
  const settled = await shown();
  await page.waitForTimeout(4000);
  await page.evaluate(() => window.tessera.settle());
  const later = await shown();
  assert.ok(psnr(before, later) < 35, 'nothing moves');
  assert.ok(psnr(settled, later) > 30, `${psnr(settled, later)} dB`);
  expectClean(problems);
});
