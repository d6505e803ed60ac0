// Tests of the harness: pages are rendered, errors of a page are recorded, and byte ranges of files
// are served.
import assert from 'node:assert/strict';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import {differing, expectClean, fixture, launchBrowser, openPage, psnr, readPng, scratchFolder,
        serve, shot, tessera} from './harness.mjs';

let browser, server;
const folder = scratchFolder();

before(async () => {
  writeFileSync(join(folder, 'grey.html'),
                '<body style="margin:0"><canvas width=64 height=48 style="background:#808080">');
  writeFileSync(join(folder, 'bad.html'), `<script src="http://tessera.invalid/a.js"></script>
    <script>console.error('wrong'); fetch('absent.bin'); setTimeout(() => { missing(); });</script>`);
  server = await serve({'/': folder, '/fixture/': fixture.folder});
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  await server?.close();
});

test('a canvas is seen with its colours, and WebGL2 is there', async () => {
  const {page, problems} = await openPage(browser, server);
  await page.goto(`${server.origin}/grey.html`);
  const image = await shot(page);
  assert.deepEqual([image.width, image.height], [64, 48]);
  assert.deepEqual([...image.data.slice(0, 4)], [128, 128, 128, 255]);
  assert.ok(await page.evaluate(
      () => document.createElement('canvas').getContext('webgl2') !== null));
  expectClean(problems);
  await page.close();
});

test('exceptions, console errors, missing files and foreign requests are noticed', async () => {
  const {page, problems} = await openPage(browser, server);
  await page.goto(`${server.origin}/bad.html`);
  await page.waitForTimeout(300);
  assert.deepEqual(problems.foreign, ['http://tessera.invalid/a.js']);
  const said = problems.errors.join('\n');
  for (const part of ['missing is not defined', 'console: wrong', '404'])
    assert.ok(said.includes(part), `${part} in ${said}`);
  assert.throws(() => expectClean(problems));
  await page.close();
});

test('ranges of files are served, and nothing beside the roots', async () => {
  const get = (path, range) => fetch(server.origin + path, {headers: range ? {Range: range} : {}});
  const whole = Buffer.from(await (await get('/fixture/model.ply')).arrayBuffer());
  assert.equal(whole.toString('latin1', 0, 3), 'ply');
  const part = await get('/fixture/model.ply', 'bytes=4-9');
  assert.equal(part.status, 206);
  assert.equal(part.headers.get('content-range'), `bytes 4-9/${whole.length}`);
  assert.deepEqual(Buffer.from(await part.arrayBuffer()), whole.subarray(4, 10));
  assert.equal((await get('/fixture/model.ply', `bytes=${whole.length}-`)).status, 416);
  assert.equal((await get('/..%2f..%2fCMakeCache.txt')).status, 404);
});

test('the program renders the fixture, and differences of images are found', () => {
  const info = JSON.parse(tessera('info', fixture.model, '--json'));
  assert.equal(info.num_gaussians, fixture.fixed + fixture.moving);
  const drawn = (time) => {
    const out = join(folder, `at_${time}`);
    tessera('render', fixture.model, '--cameras', fixture.cameras, '--time', time, '-o', out);
    return readPng(join(out, 'front.png'));
  };
  const first = drawn(0), middle = drawn(0.5);
  assert.deepEqual([first.width, first.height], [fixture.width, fixture.height]);
  assert.equal(psnr(first, first), Infinity);
  assert.ok(psnr(first, middle) < 30, `${psnr(first, middle)} dB`);
  assert.ok(differing(first, middle, 8) > 3000);
});
