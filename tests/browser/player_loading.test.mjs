// The player's page before its first image: a line of text is shown at all times and removed when
// the image is drawn.
import assert from 'node:assert/strict';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {expectClean, fixture, launchBrowser, openPage, scratchFolder, serve, tessera} from
    './harness.mjs';

const folder = scratchFolder();
let browser, server;

before(async () => {
  for (const format of ['page', 'html'])
    tessera('export', fixture.model, '--format', format, '--cameras', fixture.cameras,
            '-o', join(folder, format));
  tessera('export', fixture.model, '--format', 'spz', '--frames', 3, '--page',
          '--cameras', fixture.cameras, '-o', join(folder, 'frames'));
  browser = await launchBrowser();
  server = await serve({'/': folder});
});
after(async () => {
  await browser?.close();
  await server?.close();
});

/**
 * Runs in the page before its own script: after each callback of a frame, window.frames gets the
 * line that is seen ('' where it is hidden) and whether the canvas has been drawn on. The canvas is
 * looked at in the task that draws it: later its buffer is empty.
 */
function watchFrames() {
  window.frames = [];
  const small = Object.assign(document.createElement('canvas'), {width: 32, height: 24});
  const context = small.getContext('2d', {willReadFrequently: true});
  const isDrawn = () => {
    context.clearRect(0, 0, 32, 24);
    context.drawImage(document.getElementById('picture'), 0, 0, 32, 24);
    return context.getImageData(0, 0, 32, 24).data.some((value, i) => i % 4 !== 3 && value > 40);
  };
  const original = window.requestAnimationFrame.bind(window);
  let drawn = false;
  window.requestAnimationFrame = (callback) => original((time) => {
    callback(time);
    drawn ||= isDrawn();
    const loading = document.getElementById('loading');
    const line = document.getElementById('loading-line').textContent;
    window.frames.push({line: loading.checkVisibility() ? line : '', drawn});
  });
}

/** Opens a page; `hold`: a pattern of addresses that wait until release() is called. */
async function watch(path, hold) {
  const opened = await openPage(browser, {origin: server.origin});
  let release = () => {};
  const released = new Promise((resolve) => { release = resolve; });
  if (hold)
    await opened.page.route(hold, async (route) => {
      await released;
      await route.continue();
    });
  await opened.page.addInitScript(watchFrames);
  await opened.page.goto(`${server.origin}/${path}`);
  return {...opened, release};
}

/** All frames until the line has gone. */
async function framesOf(page) {
  await page.waitForFunction(() => window.frames.some(({line}) => line === ''));
  return page.evaluate(() => window.frames);
}

// Bug put back: the line hidden as soon as all data has arrived; seen to fail, in all three.
// On a busy machine a page can prepare its image within one frame: one of the three has to show it.
test('a line is seen until the first image is drawn, and hidden then', async () => {
  let prepared = false;
  for (const format of ['page', 'html', 'frames']) {
    const {page, problems} = await watch(`${format}/index.html?ui=0&paused&cam=front&t=1.5`);
    const frames = await framesOf(page);
    const hidden = frames.findIndex(({line}) => line === '');
    assert.ok(hidden > 0, `${format}: a first frame without a line`);
    assert.ok(frames[hidden].drawn, `${format}: no line and no image in frame ${hidden}`);
    prepared ||= frames.some(({line, drawn}) => line.startsWith('Preparing') && !drawn);
    await page.evaluate(() => window.tessera.settle());
    const last = await page.evaluate(() => window.frames.at(-1));
    assert.deepEqual(last, {line: '', drawn: true}, format);
    await page.close();
    expectClean(problems);
  }
  assert.ok(prepared, 'no page said that it was preparing');
});

// Bug put back: no line with the share; seen to fail.
test('the line has the share of the bytes that have arrived', async () => {
  const {page, problems, release} = await watch('page/index.html?paused&t=1.5', '**/static.bin');
  const line = page.locator('#loading-line');
  await page.waitForFunction(
      () => /^Loading: [1-9]\d? % of \d+ kB$/.test(
          document.getElementById('loading-line').textContent));
  assert.ok(await line.isVisible());
  release();
  await line.waitFor({state: 'hidden'});
  await page.close();
  expectClean(problems);
});
