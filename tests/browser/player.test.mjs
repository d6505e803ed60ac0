// The player's page in Chromium: its images against frames baked by the program and against the
// program's renderings; time, keys, pointer and touch; broken files; phones; and file:// addresses.
// Parts that need no browser are tested in player_reader.test.mjs and player_parts.test.mjs.
import assert from 'node:assert/strict';
import {cpSync, readFileSync, rmSync, truncateSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {differing, expectClean, fixture, launchBrowser, openPage, psnr, readPng, scratchFolder,
        serve, shot, tessera} from './harness.mjs';

const kTimes = [0, 0.25, 0.5, 0.75, 1];
const folder = scratchFolder();
const place = (...names) => join(folder, ...names);
let browser, server;

/** The page beside frames. */
function exportFrames(format) {
  tessera('export', fixture.model, '--format', format, '--frames', kTimes.length, '--page',
          '--cameras', place('transforms.json'), '-o', place(format));
}

/** A copy of the exported page that `spoil` makes worse; its name. */
function brokenPage(name, spoil) {
  cpSync(place('page'), place(name), {recursive: true});
  spoil(place(name));
  return name;
}

/** The fixture's cameras and one whose image is so small that splats are smaller than pixels. */
function rig() {
  const transforms = JSON.parse(readFileSync(fixture.cameras));
  transforms.frames.push({...transforms.frames[0], file_path: 'small', fl_x: 60, fl_y: 60});
  writeFileSync(place('transforms.json'), JSON.stringify(transforms));
  return place('transforms.json');
}

before(async () => {
  const cameras = ['--cameras', rig()];
  tessera('export', fixture.model, '--format', 'page', ...cameras, '-o', place('page'));
  tessera('export', fixture.model, '--format', 'html', ...cameras, '-o', place('html'));
  tessera('export', fixture.model, '--format', 'tessera', '--single', ...cameras,
          '-o', place('single'));
  for (const t of kTimes)
    tessera('render', fixture.model, ...cameras, '--time', t, '-o', place(`render${t}`));
  browser = await launchBrowser();
  server = await serve({'/': folder});
});
after(async () => {
  await browser?.close();
  await server?.close();
});

/** The line of the banner, once it is there. */
async function lineOn(page) {
  await page.locator('#trouble').waitFor({state: 'visible', timeout: 10000});
  return page.locator('#trouble-line').textContent();
}

/** Opens a page; `ready`: its first image is complete. */
async function open(path, {ready = true, origin = server.origin, ...more} = {}) {
  const opened = await openPage(browser, {origin, ...more});
  await opened.page.goto(`${origin}/${path}`);
  if (ready) {
    await opened.page.waitForFunction(() => window.tessera);
    await opened.page.evaluate(() => window.tessera.settle());
  }
  return opened;
}

/** The image at a time (0 to 1) without panels. */
async function pictureAt(page, t) {
  await page.evaluate((share) => {
    window.tessera.seek(share * window.tessera.duration());
    return window.tessera.settle();
  }, t);
  return shot(page);
}

/** Images of one page at all five times. */
async function filmOf(path) {
  const {page, problems} = await open(path);
  const film = [];
  for (const t of kTimes) film.push(await pictureAt(page, t));
  await page.close();
  expectClean(problems);
  return film;
}

const view = 'index.html?ui=0&paused&cam=front';
const rendered = (t, camera = 'front') => readPng(place(`render${t}`, `${camera}.png`));

// 48 dB and 51 dB were seen. Bugs put back: velocity three times too large, the rotation's parts in
// another order, SH of the opposite direction, the principal point moved; each seen to fail.
test('the 4D page shows the same as frames baked at that time and as the program',
     async () => {
  exportFrames('ply');
  const [moving, baked] = [await filmOf(`page/${view}`), await filmOf(`ply/${view}`)];
  kTimes.forEach((t, i) => {
    const [frames, program] = [psnr(moving[i], baked[i]), psnr(moving[i], rendered(t))];
    console.log(`t = ${t}: ${frames.toFixed(1)} dB to .ply, ${program.toFixed(1)} dB to render`);
    assert.ok(frames >= 45, `t = ${t}: ${frames} dB to the frame`);
    assert.ok(program >= 45, `t = ${t}: ${program} dB to tessera render`);
  });
  assert.ok(psnr(moving[0], moving[2]) < 35, 'the scene moves');
});

// Bugs put back: no dilation, or one with compensation; each seen to fail.
test('splats smaller than a pixel, from a camera of its own lens', async () => {
  const {page, problems} = await open('page/index.html?ui=0&paused&cam=small&t=1.5');
  const value = psnr(await shot(page), rendered(0.5, 'small'));
  await page.close();
  expectClean(problems);
  assert.ok(value >= 45, `${value} dB`);
});

// Bugs put back: .spz not turned, frames by index instead of time; each seen to fail.
test('sequences of compressed .ply, .spz and .splat', async () => {
  for (const [format, least] of [['compressed', 40], ['spz', 40], ['splat', 35]]) {
    exportFrames(format);
    const {page, problems} = await open(`${format}/${view}&t=0.4`);  // nearest: the second frame
    const value = psnr(await shot(page), rendered(0.25));
    await page.close();
    expectClean(problems);
    assert.ok(value >= least, `${format}: ${value} dB`);
  }
});

// Bug put back: the version of blocks not counted up when time changes; seen to fail.
test('seeking away and back gives the same image to the last bit', async () => {
  const {page, problems} = await open(`page/${view}`);
  const first = await pictureAt(page, 0.4);
  const away = await pictureAt(page, 0.6);  // the same blocks
  const back = await pictureAt(page, 0.4);
  assert.ok(differing(first, away) > 1000);
  assert.equal(differing(first, back), 0);
  await page.close();
  expectClean(problems);
});

// Bug put back: the block's offset without the manifest's length; seen to fail.
test('one file by ranges shows the same as the folder', async () => {
  cpSync(place('single', 'scene.t4d'), place('page', 'scene.t4d'));
  const images = [];
  for (const path of [`page/${view}&t=1.2`, `page/${view}&t=1.2&scene=scene.t4d`]) {
    const {page, problems} = await open(path);
    images.push(await shot(page));
    await page.close();
    expectClean(problems);
  }
  assert.equal(differing(...images), 0);
});

const wide = {width: 640, height: 480};
/** The middle of a wide page, where no panel lies. */
async function middle(page) {
  await page.evaluate(() => window.tessera.settle());
  return readPng(await page.screenshot({clip: {x: 80, y: 70, width: 480, height: 290}}));
}
const timeOf = (page) => page.evaluate(() => window.tessera.time());

// Bugs put back: no listener on the time line; a step by one second; Home without effect; turning
// without the camera's version; each seen to fail.
test('time line, keys and pointer', async () => {
  const {page, problems} = await open('page/index.html?paused&t=0', wide);
  const start = await middle(page);
  await page.locator('#timeline').evaluate((line) => {
    line.value = '1.5';
    line.dispatchEvent(new Event('input'));
  });
  assert.equal(await timeOf(page), 1.5);
  assert.ok(differing(start, await middle(page)) > 1000, 'the time line moves the image');
  await page.keyboard.press('ArrowRight');
  assert.ok(Math.abs(await timeOf(page) - 1.5 - 1 / 30) < 1e-9);
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press('End');
  assert.equal(await timeOf(page), fixture.seconds);
  await page.keyboard.press('Home');
  assert.equal(await timeOf(page), 0);
  assert.equal(differing(start, await middle(page)), 0, 'and back');
  for (const [name, act] of Object.entries({
    turn: async () => {
      await page.mouse.move(300, 200);
      await page.mouse.down();
      await page.mouse.move(380, 230, {steps: 3});
      await page.mouse.up();
    },
    pan: async () => {
      await page.mouse.move(300, 200);
      await page.mouse.down({button: 'right'});
      await page.mouse.move(340, 200, {steps: 3});
      await page.mouse.up({button: 'right'});
    },
    nearer: () => page.mouse.wheel(0, -300),
    'another camera': () => page.keyboard.press('2'),
  })) {
    const last = await middle(page);
    await act();
    assert.ok(differing(last, await middle(page)) > 1000, name);
  }
  assert.equal(await page.locator('#camera').inputValue(), '1');
  await page.keyboard.press('r');
  assert.equal(differing(start, await middle(page)), 0, 'reset');
  await page.close();
  expectClean(problems);
});

// Bugs put back: a sixtieth of a second counted for every frame; the rate left away; each seen to
// fail.
test('play follows the wall clock', async () => {
  const {page, problems} = await open('page/index.html?t=0.5&rate=0.5&cam=side&paused', wide);
  assert.equal(await timeOf(page), 0.5);
  assert.equal(await page.locator('#camera').inputValue(), '1');
  const first = await middle(page);
  await page.keyboard.press('Space');
  await page.locator('#play[aria-label="Pause (space)"]').waitFor();  // with the next image
  const ran = await page.evaluate(async () => {
    const [clip, wall] = [window.tessera.time(), performance.now()];
    await new Promise((done) => setTimeout(done, 1500));
    return {clip: window.tessera.time() - clip, wall: (performance.now() - wall) / 1000};
  });
  assert.ok(Math.abs(ran.clip - 0.5 * ran.wall) < 0.1, `${ran.clip} s of clip in ${ran.wall} s`);
  await page.keyboard.press(' ');
  const stopped = await timeOf(page);
  assert.ok(differing(first, await middle(page)) > 1000);
  assert.equal(await timeOf(page), stopped);
  assert.match(page.url(), new RegExp(`t=${stopped.toFixed(3)}`), 'the address holds the time');
  await page.close();
  expectClean(problems);
});

const segment = 'level1_0001.bin';
const kBroken = {
  'a segment is cut off': [(f) => truncateSync(join(f, segment), 100),
                           /level1_0001\.bin: 100 bytes of \d+, so it is cut off/],
  'a segment is missing': [(f) => rmSync(join(f, segment)),
                           /level1_0001\.bin: .* 404; it is missing/],
};

// Bugs put back: failures taken for blocks on their way (play stands still); the banner left hidden;
// each seen to fail.
test('playback continues with the loaded blocks and lists the missing ones', async () => {
  for (const [name, [spoil, line]] of Object.entries(kBroken)) {
    const path = `${brokenPage(name, spoil)}/index.html?t=0.9&cam=front`;
    const {page} = await open(path, {ready: false});
    assert.match(await lineOn(page), line, name);
    const early = await timeOf(page);
    await page.waitForTimeout(300);
    assert.notEqual(early, await timeOf(page), `${name}: time advances`);
    await page.evaluate(() => { window.tessera.pause(); window.tessera.seek(1.5);
                                return window.tessera.settle(); });
    assert.ok(brightness(await shot(page)) > 5, `${name}: the rest is drawn`);
    await page.close();
  }
});

const kUseless = {
  'a later version': [(f) => rewrite(f, (m) => ({...m, version: 4})),
                      /manifest\.json: version 4 is later than this player knows/],
  'no manifest': [(f) => rmSync(join(f, 'manifest.json')), /manifest\.json: .* 404; it is missing/],
};
function rewrite(f, change) {
  const path = join(f, 'manifest.json');
  writeFileSync(path, JSON.stringify(change(JSON.parse(readFileSync(path)))));
}
function brightness({data}) {
  return data.reduce((sum, value, i) => (i % 4 === 3 ? sum : sum + value), 0) / (0.75 * data.length);
}
// Bugs put back: the rejection of open() not shown; versions not compared; each seen to fail.
test('files that cannot be opened are refused with a reason', async () => {
  for (const [name, [spoil, line]] of Object.entries(kUseless)) {
    const {page} = await open(`${brokenPage(name, spoil)}/index.html`, {ready: false});
    assert.match(await lineOn(page), line, name);
    await page.close();
  }
  const {page, problems} = await openPage(browser, {origin: server.origin});
  await page.addInitScript(() => {
    const original = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function(kind, ...rest) {
      return kind === 'webgl2' ? null : original.call(this, kind, ...rest);
    };
  });
  await page.goto(`${server.origin}/page/index.html`);
  assert.match(await lineOn(page), /no WebGL2: use a current Chrome/);
  await page.close();
  expectClean(problems);
});

// Bugs put back: the scene within the page looked up as a file; the message of a server that does
// not answer; the decoder as a module in a worker, which no browser starts there, and no other way;
// each seen to fail.
test('from a disk: one file plays, a folder gives a message with the remedy', async () => {
  const origin = `file://${folder}`;
  const {page, problems} = await open(`html/index.html?ui=0&paused&t=1.5&cam=front`, {origin});
  assert.ok(psnr(await shot(page), rendered(0.5)) >= 35, 'the image is drawn');
  await page.close();
  expectClean(problems);
  const closed = await open('page/index.html', {origin, ready: false});
  assert.match(await lineOn(closed.page), /serve its folder .* or export with --format html/);
  await closed.page.close();
});

// Bugs put back: a bar of 480 pixels; buttons 60 wide; fingers that are not followed; each seen to
// fail.
test('a phone has every control in view, and a finger turns the scene', async () => {
  const phone = {width: 360, height: 640, hasTouch: true, isMobile: true};
  const {page, problems} = await open('page/index.html?paused&t=0.3', phone);
  const boxes = [];
  const controls = page.locator('.panel :is(button, select, input):visible');
  for (const control of await controls.all()) {
    const name = await control.getAttribute('aria-label');
    const box = await control.boundingBox();
    assert.ok(name, 'a control without a name');
    assert.ok(box && box.x >= 0 && box.y >= 0 && box.x + box.width <= 360 &&
              box.y + box.height <= 640, `${name} is not in view: ${JSON.stringify(box)}`);
    assert.ok(box.height >= 24 && box.width >= 24, `${name} is too small for a finger`);
    for (const other of boxes)
      assert.ok(box.x >= other.x + other.width - 0.5 || other.x >= box.x + box.width - 0.5 ||
                box.y >= other.y + other.height - 0.5 || other.y >= box.y + box.height - 0.5,
                `${name} covers ${other.name}`);
    boxes.push({...box, name});
  }
  assert.equal(boxes.length, 14);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 360);
  const clip = {x: 20, y: 150, width: 320, height: 300};
  const still = readPng(await page.screenshot({clip}));
  const client = await page.context().newCDPSession(page);
  const touch = (type, touchPoints) =>
    client.send('Input.dispatchTouchEvent', {type, touchPoints});
  await touch('touchStart', [{x: 120, y: 300}]);
  for (const x of [140, 160, 180]) await touch('touchMove', [{x, y: 300}]);
  await touch('touchEnd', []);
  await page.evaluate(() => window.tessera.settle());
  assert.ok(differing(still, readPng(await page.screenshot({clip}))) > 1000, 'it turns');
  await page.close();
  expectClean(problems);
});
