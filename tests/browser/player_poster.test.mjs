// Title, description and poster of an exported page: text is shown as it was given, link previews
// find their tags, and the poster is shown before any part of the scene has been loaded.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {differing, expectClean, fixture, launchBrowser, openPage, psnr, readPng, scratchFolder,
        serve, tessera} from './harness.mjs';

const kTitle = `</title><script>window.hostile = 1</script> "A" & 'B' {{C}}`;
const kDescription = `" /><img src=x onerror="window.hostile = 2"> a < b`;
const folder = scratchFolder();
let browser, server;

before(async () => {
  const words = ['--cameras', fixture.cameras, '--title', kTitle, '--description', kDescription];
  for (const format of ['page', 'html'])
    tessera('export', fixture.model, '--format', format, '--poster', 'auto', ...words,
            '-o', join(folder, format));
  tessera('export', fixture.model, '--format', 'spz', '--frames', 2, '--page', ...words,
          '--poster', join(folder, 'page', 'poster.png'), '-o', join(folder, 'frames'));
  browser = await launchBrowser();
  server = await serve({'/': folder});
});
after(async () => {
  await browser?.close();
  await server?.close();
});

// Bug put back: the title without html_text(); seen to fail.
test('title and description are text, whatever they hold', async () => {
  for (const format of ['page', 'html', 'frames']) {
    const {page, problems} = await openPage(browser, {origin: server.origin});
    await page.goto(`${server.origin}/${format}/index.html?paused`);
    await page.waitForFunction(() => window.tessera);
    await page.evaluate(() => window.tessera.settle());
    assert.equal(await page.title(), kTitle);
    assert.equal(await page.locator('#title').textContent(), kTitle);
    assert.equal(await page.evaluate(() => window.hostile), undefined);
    const meta = (name) => page.locator(`meta[${name}]`).getAttribute('content');
    for (const name of ['name="description"', 'property="og:description"'])
      assert.equal(await meta(name), kDescription);
    assert.equal(await meta('property="og:title"'), kTitle);
    const image = page.locator('meta[property="og:image"]');
    assert.equal(await image.count(), format === 'html' ? 0 : 1);
    if (format !== 'html') assert.equal(await image.getAttribute('content'), 'poster.png');
    await page.keyboard.press('?');
    assert.equal(await page.locator('#description').textContent(), kDescription);
    await page.close();
    expectClean(problems);
  }
  assert.deepEqual(readFileSync(join(folder, 'frames', 'poster.png')),
                   readFileSync(join(folder, 'page', 'poster.png')));
});

// Bugs put back: the poster left hidden; left on the canvas for good; rendered at the last
// timestep; each seen to fail.
test('the poster is seen within two seconds, before the scene, and removed when it is drawn',
     async () => {
  const {page, problems} = await openPage(browser, {origin: server.origin});
  let release;
  const released = new Promise((resolve) => { release = resolve; });
  await page.route('**/*.bin', async (route) => {
    await released;
    await route.continue();
  });
  const begin = Date.now();
  await page.goto(`${server.origin}/page/index.html?paused&cam=front&ui=0`, {waitUntil: 'commit'});
  await page.waitForFunction(() => document.getElementById('poster')?.checkVisibility() &&
                                   document.getElementById('poster').naturalWidth > 0);
  assert.ok(Date.now() - begin < 2000, `${Date.now() - begin} ms`);
  await page.waitForFunction(() => /%/.test(document.getElementById('loading-line').textContent));
  assert.ok(await page.locator('#loading-line').isVisible());
  await page.evaluate(() => { document.getElementById('loading').style.opacity = 0; });
  const before = readPng(await page.screenshot());
  release();
  await page.locator('#poster').waitFor({state: 'detached'});
  assert.equal(await page.locator('#poster-around').count(), 0);
  await page.evaluate(() => window.tessera.settle());
  const after = readPng(await page.screenshot());
  const value = psnr(before, after);
  assert.ok(value >= 40, `the poster is the view that follows it: ${value} dB`);
  assert.ok(differing(before, after) > 0, 'it is a rendered image, not the canvas');
  await page.close();
  expectClean(problems);
});

// Bug put back: files taken for PNG whatever they are; seen to fail.
test('a poster that is no image, and options without a page, are refused', () => {
  writeFileSync(join(folder, 'text.png'), 'no image');
  const refusal = (...words) => {
    try {
      tessera('export', fixture.model, '-o', join(folder, 'refused'), ...words);
    } catch (error) {
      return error.stderr;
    }
    return 'accepted';
  };
  assert.match(refusal('--format', 'html', '--poster', join(folder, 'text.png')),
               /text\.png: is no PNG, JPEG or WebP image/);
  assert.match(refusal('--format', 'html', '--poster', 'auto'), /--poster auto needs a camera/);
  assert.match(refusal('--format', 'ply', '--title', 'a'), /--title is for pages/);
});
