// The automatic camera path of the player's page: the order of the cameras, the curve through them,
// and the events that start and end it.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {expectClean, openPage} from './harness.mjs';
import {playerModules} from './player_modules.mjs';
import {pageOfModel} from './player_page.mjs';

const {Playback, lookRotation, pathOf, poseOfWord, rigPose, tourOf} =
    await playerModules('path', 'shared_view', 'tour', 'view_camera');
const site = pageOfModel();

const kInfo = {cameras: [], bounds: {min: [-1, -1, -1], max: [1, 1, 1]}, up: [0, -1, 0]};
const vectorAt = (...place) => poseOfWord([...place, 1, 0, 0, 0, 50].join(), kInfo).position;

/** The same camera at a place, level, turned to a target. */
function turnedTo(camera, place, target) {
  const ahead = vectorAt(...target).sub(vectorAt(...place));
  const {x, y, z, w} = lookRotation(ahead, vectorAt(...kInfo.up));
  return {...camera, position: place, rotation: [w, x, y, z]};
}

/** A level camera at 4 units from the middle, to which it looks. */
function cameraAt(degrees) {
  const a = degrees * Math.PI / 180;
  return {name: `at${degrees}`, position: [4 * Math.sin(a), 0, -4 * Math.cos(a)],
          rotation: [Math.cos(-a / 2), 0, Math.sin(-a / 2), 0],
          width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240};
}

// Bugs put back: the order of the file; the nearest one alone, without 2-opt; another one first;
// each seen to fail.
test('a tour is short and begins with the first camera', () => {
  const lengthOf = (places, order) => order.reduce(
      (sum, i, k) => sum + places[i].distanceTo(places[order[(k + 1) % order.length]]), 0);
  const ring = [0, 150, 60, 240, 330, 90, 300, 30, 180, 120, 270, 210].map((degrees) =>
      vectorAt(...cameraAt(degrees).position));
  const order = tourOf(ring);
  assert.deepEqual([...order].sort((a, b) => a - b), [...ring.keys()]);
  assert.equal(order[0], 0);
  assert.ok(Math.abs(lengthOf(ring, order) - 12 * 8 * Math.sin(Math.PI / 12)) < 1e-9);
  // a wall of 4 × 4 cameras, one unit apart: there is a tour without a longer leg
  const wall = [...Array(16).keys()].map((i) => vectorAt((i * 7) % 16 % 4, ((i * 7) % 16) >> 2, 0));
  assert.ok(lengthOf(wall, tourOf(wall)) < 17.7, `${lengthOf(wall, tourOf(wall))}`);
  // the nearest one each time leads from 0 by 1, −2 and 3.5 to −6, and a long way back
  const line = [0, 1, -2, 3.5, -6].map((x) => vectorAt(x, x === 0 ? 0 : 0.1, 0));
  assert.ok(lengthOf(line, tourOf(line)) < 19.2, `${lengthOf(line, tourOf(line))}`);
  assert.deepEqual(tourOf([]), []);
});

// Bugs put back: straight legs; a curve that is not closed; one time for every leg; rotations that
// are blended without regard to the vertical; the target of the first camera kept; each seen to
// fail.
test('the path is smooth and level, and leads through every camera', () => {
  const info = {...kInfo, cameras: [0, 200, 70, 290, 120].map(cameraAt)};
  info.cameras[2] = turnedTo(info.cameras[2], [3.2, -1.5, -1], [0.5, 0.3, 0]);
  info.cameras[3] = turnedTo(info.cameras[3], [-3.2, 1, -1], [0, -0.8, 0.4]);
  const path = pathOf(info);
  assert.equal(path.seconds, 15);
  const count = 3000;
  const poses = Array.from({length: count}, (_, k) => path.poseAt(k / count));
  for (const camera of info.cameras) {
    const view = rigPose(camera, info);
    const away = poses.map(({position}) => position.distanceTo(view.position));
    const least = Math.min(...away);
    assert.ok(least < 0.01, `${camera.name}: ${least}`);
    const turned = poses[away.indexOf(least)].rotation.angleTo(view.rotation);
    assert.ok(turned < 0.02, `${camera.name}: ${turned}`);
  }
  const start = path.poseAt(0), first = rigPose(info.cameras[0], info);
  assert.ok(start.rotation.angleTo(first.rotation) < 1e-6);
  assert.ok(start.position.distanceTo(path.poseAt(1).position) < 1e-6, 'closed');
  const step = (k) => poses[(k + 1) % count].position.clone().sub(poses[k].position);
  const mean = poses.reduce((sum, _, k) => sum + step(k).length(), 0) / count;
  for (let k = 0; k < count; ++k) {
    const [way, next] = [step(k), step((k + 1) % count)];
    assert.ok(Math.abs(way.length() / mean - 1) < 0.1, `one speed: ${way.length() / mean} at ${k}`);
    assert.ok(way.angleTo(next) < 0.05, `no corner: ${way.angleTo(next)} at ${k}`);
    const right = way.clone().set(1, 0, 0).applyQuaternion(poses[k].rotation);
    assert.ok(Math.abs(right.y) < 1e-6, `level: ${right.y} at ${k}`);
    assert.ok(poses[k].rotation.angleTo(poses[(k + 1) % count].rotation) < 0.02, 'no jump');
    assert.ok(poses[k].position.length() > 2, 'around the scene');
  }
  const many = {...kInfo, cameras: [...Array(30).keys()].map((i) => cameraAt(12 * i))};
  assert.equal(pathOf(many).seconds, 40);
});

// Bugs put back: level looks of cameras that look straight down; a turn of the place alone; each
// seen to fail.
test('cameras that look down are blended, and a scene without cameras is turned', () => {
  const down = [[0, 0], [2, 0], [2, 2], [0, 2]].map(([x, z], i) => ({
    ...cameraAt(0), name: `down${i}`, position: [x, -5, z],
    rotation: [Math.SQRT1_2, -Math.SQRT1_2, 0.001 * i, 0],
  }));
  const path = pathOf({...kInfo, cameras: down});
  const from = path.poseAt(0).rotation;
  for (let k = 0; k < 100; ++k)
    assert.ok(path.poseAt(k / 100).rotation.angleTo(from) < 0.02, `${k}`);
  const turn = pathOf(kInfo);
  const [home, quarter] = [turn.poseAt(0), turn.poseAt(0.25)];
  assert.ok(Math.abs(home.position.y - quarter.position.y) < 1e-9);
  assert.ok(Math.abs(home.position.length() - quarter.position.length()) < 1e-9);
  assert.ok(Math.abs(home.rotation.angleTo(quarter.rotation) - Math.PI / 2) < 0.1);
  const ahead = home.position.clone().set(0, 0, quarter.distance).applyQuaternion(quarter.rotation);
  assert.ok(ahead.add(quarter.position).length() < 1e-6, 'the middle stays in the middle');
});

// Bugs put back: a path from its beginning wherever the camera is; the pose of the path at once;
// each seen to fail.
test('it begins at rest at the view that is shown', () => {
  const info = {...kInfo, cameras: [0, 90, 180, 270].map(cameraAt)};
  const wall = {now: 7}, set = [];
  const playback = new Playback(info, (pose) => set.push(pose), () => wall.now);
  const from = rigPose(cameraAt(95), info);
  playback.start(from);
  for (let k = 0; k < 200; ++k, wall.now += 0.01) playback.step();
  assert.ok(set[0].position.distanceTo(from.position) < 1e-6);
  assert.ok(set[0].rotation.angleTo(from.rotation) < 1e-6);
  const way = (k) => set[k + 1].position.distanceTo(set[k].position);
  assert.ok(way(0) < 0.1 * way(190), `${way(0)} and ${way(190)}`);
  assert.ok(Math.max(...[...Array(199).keys()].map(way)) < 2 * way(190), 'without a leap');
  playback.stop();
  playback.step();
  assert.equal(set.length, 200);
});

async function open(query, more = {}) {
  const size = {width: 640, height: 480};
  const opened = await openPage(site.browser, {origin: site.origin, ...size, ...more});
  await opened.page.goto(`${site.address}?paused&${query}`);
  await opened.page.waitForFunction(() => window.tessera);
  await opened.page.locator('#loading').waitFor({state: 'hidden'});
  return opened;
}
const wordOf = (page) => page.evaluate(() => window.tessera.view());
/** Waits for another view. */
async function moves(page) {
  await page.waitForFunction((word) => window.tessera.view() !== word, await wordOf(page));
}
/** Whether the view comes to rest. */
async function rests(page) {
  for (let last = '', round = 0; round < 8; ++round) {
    const word = await wordOf(page);
    if (word === last) return true;
    last = word;
    await page.waitForTimeout(700);
  }
  return false;
}
const pressed = (page) => page.locator('#path').getAttribute('aria-pressed');

/** Until the address has no such word: it follows the page a little later. */
const without = (page, word) => page.waitForURL((url) => !url.searchParams.has(word));

// Bugs put back: a word of the address that is not read; drags, wheels, cameras and settle() that
// do not end it; an address that keeps the word; a button that does not show it; a path that begins
// before the first image, so that none is ever complete; each seen to fail.
test('the address, the key and the button start it, and whatever moves the camera ends it',
     async () => {
  const {page, problems} = await open('path');
  await moves(page);
  assert.equal(await pressed(page), 'true');
  assert.match(page.url(), /path=/);
  const ends = {
    drag: async () => {
      await page.mouse.move(300, 200);
      await page.mouse.down();
      await page.mouse.move(310, 200);
      await page.mouse.up();
    },
    wheel: () => page.mouse.wheel(0, 100),
    camera: () => page.keyboard.press('2'),
    'settle()': () => page.evaluate(() => window.tessera.settle()),
    'the button': () => page.locator('#path').click(),
  };
  for (const [name, end] of Object.entries(ends)) {
    if (await pressed(page) === 'false') await page.keyboard.press('p');
    await moves(page);
    await end();
    await page.locator('#path[aria-pressed="false"]').waitFor();  // events may come late
    await without(page, 'path');
    assert.ok(await rests(page), name);
  }
  await page.waitForURL(/view=/);
  await page.keyboard.press('p');
  await without(page, 'view');
  await page.close();
  expectClean(problems);
});

// Bugs put back: a start by itself although less motion is preferred; a button that does nothing
// then; each seen to fail.
test('where less motion is preferred it waits for the button', async () => {
  const {page, problems} = await open('path', {reducedMotion: 'reduce'});
  assert.ok(await rests(page));
  assert.equal(await pressed(page), 'false');
  await page.locator('#path').click();
  await moves(page);
  await page.close();
  expectClean(problems);
});
