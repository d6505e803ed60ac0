// The report of a run in Chromium, opened from the disk: it fits wide and narrow windows, loads
// nothing from elsewhere, and its sliders and tables work.
import assert from 'node:assert/strict';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import {launchBrowser, scratchFolder, tessera} from './harness.mjs';

const folder = scratchFolder();
const run = join(folder, 'run');
let browser;

before(async () => {
  const capture = join(folder, 'capture');
  tessera('synth', 'object', '-o', capture, '--layout', 'dnerf', '--frames', 8,
          '--held-out-frames', 3, '--width', 64, '--height', 48);
  tessera('train', capture, '-o', run, '--backend', 'cpu', '--iterations', 30, '--motion', 'pair',
          '--evaluate-every', 10);
  tessera('report', run);
  browser = await launchBrowser();
});
after(() => browser?.close());

/** The page in a window of this size, and all that went wrong on it. */
async function opened(width, height) {
  const page = await browser.newPage({viewport: {width, height}});
  const wrong = [];
  page.on('pageerror', (error) => wrong.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && wrong.push(message.text()));
  page.on('request', (request) => {
    if (!/^(file|data):/.test(request.url())) wrong.push(request.url());
  });
  await page.goto(`file://${run}/report/index.html`);
  return {page, wrong};
}

// Bug put back: columns of charts that are never narrower than 28rem; seen to fail at 390 pixels.
for (const [width, height] of [[1280, 720], [390, 844]])
  test(`fits a window of ${width} pixels and asks for nothing`, async () => {
    const {page, wrong} = await opened(width, height);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    assert.equal(await page.locator('.charts svg').count(), 4);
    const broken = await page.evaluate(
        () => [...document.images].filter((image) => !image.complete || image.naturalWidth === 0)
                  .length);
    assert.equal(broken, 0);
    assert.deepEqual(wrong, []);
    await page.close();
  });

// Bug put back: the slider without its listener; seen to fail.
test('the line between truth and result follows pointer and keys', async () => {
  const {page, wrong} = await opened(1280, 720);
  const compare = page.locator('.compare').first();
  const place = () => compare.evaluate((element) => element.style.getPropertyValue('--at'));
  await compare.scrollIntoViewIfNeeded();
  const box = await compare.boundingBox();
  await page.mouse.click(box.x + 0.25 * box.width, box.y + 0.5 * box.height);
  assert.ok(Math.abs(parseFloat(await place()) - 25) < 1, await place());
  await page.locator('.slider').first().focus();
  await page.keyboard.press('End');
  assert.equal(await place(), '100%');
  assert.deepEqual(wrong, []);
  await page.close();
});

// Bug put back: numbers compared as text; seen to fail.
test('the table of views is sorted by a click', async () => {
  const {page} = await opened(1280, 720);
  await page.evaluate(() => {
    document.querySelector('details').open = true;
    document.querySelector('tbody td.number + td.number').textContent = '9.5';
  });
  const column = () => page.locator('tbody tr td:nth-child(4)').allTextContents();
  await page.locator('th', {hasText: 'PSNR'}).click();
  const up = (await column()).map(Number);
  assert.deepEqual(up, [...up].sort((a, b) => a - b));
  assert.equal(up[0], 9.5);
  await page.locator('th', {hasText: 'PSNR'}).click();
  assert.equal((await column()).map(Number).at(-1), 9.5);
  await page.close();
});
