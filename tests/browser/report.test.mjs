// The reports of real runs in Chromium, opened from the disk: what the program writes is what the
// page shows. report_page.test.mjs has what can be done there.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import {launchBrowser, scratchFolder, tessera} from './harness.mjs';

const folder = scratchFolder();
const run = join(folder, 'run');
const capture = join(folder, 'capture');
let browser;

before(async () => {
  tessera('synth', 'object', '-o', capture, '--layout', 'dnerf', '--frames', 8,
          '--held-out-frames', 3, '--width', 64, '--height', 48);
  tessera('train', capture, '-o', run, '--backend', 'cpu', '--iterations', 30, '--motion', 'pair',
          '--evaluate-every', 10);
  tessera('report', run);
  browser = await launchBrowser();
});
after(() => browser?.close());

/** The page in a window of this size, and all that went wrong on it. */
async function opened(report, width, height) {
  const page = await browser.newPage({viewport: {width, height}});
  const wrong = [];
  page.on('pageerror', (error) => wrong.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && wrong.push(message.text()));
  page.on('request', (request) => {
    if (!/^(file|data):/.test(request.url())) wrong.push(request.url());
  });
  await page.goto(`file://${report}/index.html`);
  return {page, wrong};
}

// Bugs put back: images relative to the page, though it has them inside; views of a run without their
// images; seen to fail.
for (const [width, height] of [[1280, 720], [390, 844]])
  test(`the report of a run shows its scores, views and curves, ${width} pixels wide`, async () => {
    const {page, wrong} = await opened(`${run}/report`, width, height);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    const {runs: [{scores, views}]} =
        JSON.parse(readFileSync(join(run, 'report', 'report.json'), 'utf8'));
    const text = await page.locator('main').innerText();
    assert.match(text, new RegExp(`PSNR\\s+${scores.psnr.toFixed(2)} dB`));
    assert.equal(await page.locator('.u-over').count(), 4, 'charts');
    assert.ok(await page.locator('img').count() >= 2 + views.length, 'the view and thumbnails');
    const broken = await page.evaluate(
        () => [...document.images].filter((image) => image.src && !image.hidden &&
                                          image.complete && image.naturalWidth === 0).length);
    assert.equal(broken, 0);
    assert.deepEqual(wrong, []);
    await page.close();
  });

// Bugs put back: the images of the first run in the place of those of the second; a report that
// leads to itself; each seen to fail.
test('the report of two runs compares them', async () => {
  tessera('train', capture, '-o', join(folder, 'other'), '--backend', 'cpu', '--iterations', 10,
          '--motion', 'pair', '--seed', 7);
  const out = join(folder, 'compared');
  tessera('report', run, join(folder, 'other'), '-o', out);
  const {page, wrong} = await opened(out, 1280, 720);
  const text = await page.locator('main').innerText();
  for (const part of ['run', 'other', 'seed', 'iterations']) assert.ok(text.includes(part), part);
  const {runs} = JSON.parse(readFileSync(join(out, 'report.json'), 'utf8'));
  assert.deepEqual(runs.map(({title}) => title), ['run', 'other']);
  assert.equal(runs[0].views[0].truth, runs[1].views[0].truth, 'one file');
  assert.notEqual(runs[0].views[0].result, runs[1].views[0].result);
  const ofReports = ({files}) => files.filter(({name}) => name === 'Report').map(({path}) => path);
  assert.deepEqual(runs.map(ofReports), [['../run/report/index.html'], []]);
  tessera('report', run); // once more
  const alone = JSON.parse(readFileSync(join(run, 'report', 'report.json'), 'utf8'));
  assert.deepEqual(ofReports(alone.runs[0]), []);
  assert.deepEqual(wrong, []);
  await page.close();
});
