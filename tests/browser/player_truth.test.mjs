// Test images within a page of the player: they are drawn over the model at their camera and their
// time and removed when either changes. The scene's images are renderings of the model itself.
import assert from 'node:assert/strict';
import {mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {expectClean, fixture, launchBrowser, openPage, psnr, readPng, scratchFolder, serve,
        tessera} from './harness.mjs';

const folder = scratchFolder();
const scene = join(folder, 'scene');
const kTimes = {front: 10, side: 11.5, above: 13};
let browser, server;

before(async () => {
  mkdirSync(scene);
  const transforms = JSON.parse(readFileSync(fixture.cameras, 'utf8'));
  for (const frame of transforms.frames) {
    frame.time = kTimes[frame.file_path];
    frame.split = frame.file_path === 'above' ? 'train' : 'test';
  }
  writeFileSync(join(folder, 'views.json'), JSON.stringify(transforms));
  tessera('render', fixture.model, '--cameras', join(folder, 'views.json'), '-o', scene);
  for (const frame of transforms.frames) frame.file_path += '.png';
  writeFileSync(join(scene, 'transforms.json'), JSON.stringify(transforms));
  tessera('export', fixture.model, '--format', 'html', '--cameras', scene, '--truth',
          '-o', join(folder, 'page'));
  browser = await launchBrowser();
  server = await serve({'/': folder});
});
after(async () => {
  await browser?.close();
  await server?.close();
});

async function opened(size = {}) {
  const page = await openPage(browser, {origin: server.origin, ...size});
  await page.page.goto(`${server.origin}/page/index.html?paused`);
  await page.page.waitForFunction(() => window.tessera);
  await page.page.evaluate(() => window.tessera.settle());
  return page;
}

/** The window with `share` per cent of the test image, without panels. */
async function shown(page, share) {
  await page.evaluate((value) => {
    const range = document.getElementById('truth-share');
    range.value = value;
    range.dispatchEvent(new Event('input'));
    return window.tessera.settle();
  }, share);
  return readPng(await page.screenshot({style: '.panel, #truth-line { visibility: hidden; }'}));
}

// Bugs put back: the time of the view not taken; the camera not taken; the image over the whole
// window (object-fit: fill); a free view in the list of cameras; each seen to fail.
test('each test image lies on the image of the model', async () => {
  const {page, problems} = await opened({width: 900, height: 560});
  await page.keyboard.press('t');
  const options = await page.locator('#truth-view option').allInnerTexts();
  assert.deepEqual(options.map((name) => /front|side/.exec(name)?.[0]).sort(), ['front', 'side']);
  for (const i of [0, 1]) {
    await page.selectOption('#truth-view', String(i));
    await page.waitForFunction(() => document.getElementById('truth').complete);
    const value = psnr(await shown(page, 0), await shown(page, 100));
    assert.ok(value >= 30, `${options[i]}: ${value} dB`);
    const camera = await page.evaluate(() => document.getElementById('camera').selectedOptions[0].text);
    assert.ok(options[i].includes(camera), `${options[i]} as ${camera}`);
    const time = await page.evaluate(() => window.tessera.time());
    assert.ok(Math.abs(time - (kTimes[/front|side/.exec(options[i])[0]] - 10)) < 1e-3, `${time} s`);
  }
  writeFileSync(join(folder, 'half.png'), await page.screenshot());
  expectClean(problems);
  await page.close();
});

// Bugs put back: no call of end() where the camera moves; none of keep(); each seen to fail.
test('another camera and another time end the comparison', async () => {
  const {page, problems} = await opened({width: 640, height: 480});
  const isOn = () => page.evaluate(() => !document.getElementById('truth').hidden);
  const begin = async () => {
    await page.click('#compare');
    await page.evaluate(() => window.tessera.settle());
    assert.ok(await isOn());
  };
  const leaves = [
    () => page.evaluate(() => window.tessera.seek(0.7)), () => page.keyboard.press('2'),
    () => page.evaluate(() => window.tessera.play()), () => page.keyboard.press('t'),
    () => page.mouse.move(320, 200).then(() => page.mouse.wheel(0, 100)),
  ];
  for (const leave of leaves) {
    await begin();
    await leave();
    await page.waitForFunction(() => document.getElementById('truth').hidden);
    await page.evaluate(() => window.tessera.pause());
  }
  expectClean(problems);
  await page.close();
});

// Bugs put back: the line without its listeners, so that the drag orbits and ends the comparison; the
// line at the share of the other side; the key without next(); each seen to fail.
test('the line between model and test image is dragged on the image', async () => {
  const {page, problems} = await opened({width: 900, height: 560});
  await page.keyboard.press('t');
  const share = () => page.evaluate(() => Number(document.getElementById('truth-share').value));
  const middle = async () => {
    const box = await page.locator('#truth-line').boundingBox();
    return box.x + box.width / 2;
  };
  assert.ok(Math.abs(await middle() - 450) < 1);
  await page.mouse.move(450, 200);
  await page.mouse.down();
  await page.mouse.move(225, 210, {steps: 3});
  await page.mouse.up();
  assert.ok(Math.abs(await middle() - 225) < 1, `${await middle()}`);
  assert.equal(await share(), 75);
  assert.equal(await page.evaluate(() => document.getElementById('truth').hidden), false);
  const name = () => page.evaluate(() => document.getElementById('truth-view').value);
  const first = await name();
  await page.keyboard.press('n');
  assert.notEqual(await name(), first);
  assert.equal(await page.locator('#truth-line').isVisible(), true);
  await page.screenshot({path: join(folder, 'line.png')});
  await page.keyboard.press('t');
  assert.equal(await page.locator('#truth-line').isVisible(), false);
  expectClean(problems);
  await page.close();
});

// Bug put back: the slider has another word for the test image than the line; seen to fail.
test('a phone has room for the panel; a page without test images has no button', async () => {
  const {page, problems} = await opened({width: 390, height: 844});
  await page.click('#compare');
  const box = await page.locator('#comparison').boundingBox();
  assert.ok(box.x >= 0 && box.x + box.width <= 390, JSON.stringify(box));
  const words = await page.locator('#truth-line span, #comparison .sides').allInnerTexts();
  assert.deepEqual(words.map((text) => text.replace('\n', ' ')), ['model', 'test image', 'model test image']);
  const bar = await page.locator('#bar').boundingBox();
  assert.ok(box.y + box.height <= bar.y, 'above the time line');
  await page.evaluate(() => window.tessera.settle());
  writeFileSync(join(folder, 'phone.png'), await page.screenshot());
  expectClean(problems);
  await page.close();
  tessera('export', fixture.model, '--format', 'html', '--cameras', scene, '-o', join(folder, 'none'));
  const plain = await openPage(browser, {origin: server.origin});
  await plain.page.goto(`${server.origin}/none/index.html?paused`);
  await plain.page.waitForFunction(() => window.tessera);
  assert.equal(await plain.page.locator('#compare').isVisible(), false);
  await plain.page.keyboard.press('t');
  assert.equal(await plain.page.locator('#comparison').isVisible(), false);
  expectClean(plain.problems);
  await plain.page.close();
});

// Bug put back: --truth taken for frames without a page; seen to fail.
test('test images need a scene and a page', () => {
  const refusal = (...words) => {
    try {
      tessera('export', fixture.model, '-o', join(folder, 'refused'), '--truth', ...words);
    } catch (error) {
      return error.stderr;
    }
    return 'accepted';
  };
  assert.match(refusal('--format', 'html'), /--truth needs the scene's images.*--cameras/);
  assert.match(refusal('--format', 'ply'), /--truth is for pages/);
});
