// The player's images of Gaussians carried by motion nodes, beside static and dynamic ones, against
// frames baked by the program and against the program's renderings. Time, playback and the page as
// one file are tested too.
import assert from 'node:assert/strict';
import {cpSync, mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {differing, expectClean, fixture, launchBrowser, openPage, psnr, readPng, scratchFolder,
        serve, shot, tessera} from './harness.mjs';
import {carriedStreams, makeBlock, makeManifest, plainStreams} from './tessera4d_writer.mjs';

const kTimes = [0, 0.2, 0.5, 0.85, 1];
const folder = scratchFolder();
const place = (...names) => join(folder, ...names);
const view = 'index.html?ui=0&paused&cam=front';
let browser, server;

before(async () => {
  const cameras = ['--cameras', fixture.cameras];
  tessera('export', fixture.carried, '--format', 'page', ...cameras, '-o', place('page'));
  tessera('export', fixture.carried, '--format', 'page', '--lossless', ...cameras,
          '-o', place('lossless'));
  tessera('export', fixture.carried, '--format', 'html', ...cameras, '-o', place('html'));
  for (const t of kTimes)
    tessera('render', fixture.carried, ...cameras, '--time', t, '-o', place(`render${t}`));
  browser = await launchBrowser();
  server = await serve({'/': folder});
});
after(async () => {
  await browser?.close();
  await server?.close();
});

async function open(path, origin = server.origin) {
  const opened = await openPage(browser, {origin});
  await opened.page.goto(`${origin}/${path}`);
  await opened.page.waitForFunction(() => window.tessera);
  await opened.page.evaluate(() => window.tessera.settle());
  return opened;
}

/** The image at a time (0 to 1). */
async function pictureAt(page, t) {
  await page.evaluate((share) => {
    window.tessera.seek(share * window.tessera.duration());
    return window.tessera.settle();
  }, t);
  return shot(page);
}

const rendered = (t, camera = 'front') => readPng(place(`render${t}`, `${camera}.png`));

/** Images of a page at all times. */
async function filmOf(path) {
  const {page, problems} = await open(path);
  const film = [];
  for (const t of kTimes) film.push(await pictureAt(page, t));
  await page.close();
  expectClean(problems);
  return film;
}

// 47 dB and 54 dB (lossless) were seen. Bugs put back: signs of quaternions ignored; the product of
// quaternions in the other order; rotations at rest; four of eight bindings; poses that do not go to
// the card again when time changes; each seen to fail.
test('canonical, static and dynamic Gaussians look as the program renders them', async () => {
  const kinds = JSON.parse(readFileSync(place('page', 'manifest.json'))).blocks.map((b) => b.kind);
  assert.deepEqual([...new Set(kinds)].sort(), ['canonical', 'dynamic', 'static']);
  for (const name of ['page', 'lossless'])
    for (const camera of ['front', 'above']) {
      const film = await filmOf(`${name}/index.html?ui=0&paused&cam=${camera}`);
      kTimes.forEach((t, i) => {
        const value = psnr(film[i], rendered(t, camera));
        console.log(`${name}, ${camera}, t = ${t}: ${value.toFixed(1)} dB`);
        assert.ok(value >= 45, `${name}, ${camera}, t = ${t}: ${value} dB`);
      });
    }
});

// Bug put back: signs of quaternions ignored; seen to fail.
test('a frame baked at its time is the same image', async () => {
  tessera('export', fixture.carried, '--format', 'ply', '--frames', 5, '--page',
          '--cameras', fixture.cameras, '-o', place('ply'));
  const images = [];
  for (const name of ['page', 'ply']) {
    const {page, problems} = await open(`${name}/${view}`);
    images.push(await pictureAt(page, 0.75));
    await page.close();
    expectClean(problems);
  }
  const value = psnr(...images);
  console.log(`${value.toFixed(1)} dB to the frame`);
  assert.ok(value >= 45, `${value} dB`);
});

// Bug put back: poses of the time that was drawn before; seen to fail.
test('seeking away and back, and playing over the end, gives the same image', async () => {
  const {page, problems} = await open(`page/${view}`);
  const first = await pictureAt(page, 0.4);
  assert.ok(differing(first, await pictureAt(page, 0.6)) > 1000, 'nodes move');
  assert.equal(differing(first, await pictureAt(page, 0.4)), 0);
  await page.evaluate(async () => {
    window.tessera.seek(window.tessera.duration() - 0.2);
    window.tessera.play();
    while (window.tessera.time() > window.tessera.duration() / 2)
      await new Promise((done) => setTimeout(done, 20));
    window.tessera.pause();
  });
  assert.equal(differing(first, await pictureAt(page, 0.4)), 0, 'after the loop');
  await page.close();
  expectClean(problems);
});

// Bug put back: four of eight bindings; seen to fail.
test('one file from a disk plays', async () => {
  const {page, problems} = await open(`html/${view}&t=1.5`, `file://${folder}`);
  const value = psnr(await shot(page), rendered(0.5));
  await page.close();
  expectClean(problems);
  assert.ok(value >= 45, `${value} dB`);
});

/** A page of one block that was written by hand. */
function handmade(name, block, version) {
  mkdirSync(place(name));
  cpSync(place('page', 'index.html'), place(name, 'index.html'));
  const camera = {name: 'front', position: [0, 0, -4], rotation: [1, 0, 0, 0], width: 320,
                  height: 240, fx: 300, fy: 300, cx: 160, cy: 120};
  const manifest = makeManifest([block], {version, cameras: [camera]});
  writeFileSync(place(name, 'manifest.json'), JSON.stringify(manifest));
  writeFileSync(place(name, 'a.bin'), block.bytes);
  return name;
}

// 77 dB were seen. Bugs put back: colour towards the place at rest; what no node carries drawn at the
// origin; each seen to fail.
test('half a turn of a node is a static scene that is known', async () => {
  const [c, s] = [Math.cos(0.4), Math.sin(0.4)];
  const floats = (rows) => ({type: 'f32', rows});
  const same = {
    log_scale: floats(Array(3).fill([-0.9, -2, -1.5])),
    opacity: floats([[0.8], [0.9], [0.7]]),
    colour: floats([[1, 0, -1], [-1, 1, 0], [0, 0, 1]]),
    sh1: floats(Array(3).fill([0.1, 0.2, 0.3, 0.9, -0.9, 0.5, 0.8, 0.2, -0.6])),
  };
  // (x, y, z) -> (0.3 − x, y, −z); the third has no node
  const nodes = {kind: 'canonical', nodes: 2, knots: 4};
  const turning = makeBlock({...nodes, count: 3, file: 'a.bin', streams: {
    ...carriedStreams(3), ...same,
    position: floats([[0.5, 0.2, -1], [0.1, 0, 1], [-0.6, -0.4, 0]]),
    rotation: floats([[c, 0, 0, s], [1, 0, 0, 0], [1, 0, 0, 0]]),
    node: {type: 'u8', rows: [...Array(2).fill([2, ...Array(7).fill(0)]), Array(8).fill(0)],
           bias: Array(8).fill(-1)},
    node_translation: floats(Array(8).fill([-1.7, 0, 0])),
    node_position: floats([[0, 0, 0], [1, 0, 0]]),
    node_rotation: floats(Array(8).fill([0, 0, 1, 0])),
  }});
  const still = makeBlock({count: 3, file: 'a.bin', streams: {
    ...plainStreams(3), ...same,
    position: floats([[-0.2, 0.2, 1], [0.2, 0, -1], [-0.6, -0.4, 0]]),
    rotation: floats([[0, s, c, 0], [0, 0, 1, 0], [1, 0, 0, 0]]),
  }});
  const images = [];
  for (const name of [handmade('turning', turning, 2), handmade('still', still, 1)]) {
    const {page, problems} = await open(`${name}/${view}&t=0.3`);
    images.push(await shot(page));
    await page.close();
    expectClean(problems);
  }
  const value = psnr(...images);
  console.log(`${value.toFixed(1)} dB to the static scene`);
  assert.ok(value >= 60, `${value} dB`);
  assert.ok(images[0].data.filter((v, i) => i % 4 !== 3 && v > 100).length > 2000, 'it is there');
});
