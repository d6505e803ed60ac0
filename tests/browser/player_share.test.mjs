// A free view in the address of the player's page: encoded and decoded, in a page that is opened
// with it, and through the Share button.
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {differing, expectClean, openPage, psnr, readPng} from './harness.mjs';
import {playerModules} from './player_modules.mjs';
import {pageOfModel} from './player_page.mjs';

const {embedLine, imageName, poseOfWord, share, shareEmbed, viewWord} =
    await playerModules('shared_view', 'share');
const site = pageOfModel();

const kLens = {fx: 500, fy: 500, cx: 320, cy: 240, width: 640, height: 480};
const kInfo = {cameras: [], bounds: {min: [-1, -1, -1], max: [1, 1, 1]}, up: [0, -1, 0]};

// Bugs put back: qw last; the field of view in radians; words of nine numbers accepted; each seen
// to fail.
test('a view as a word, and back', () => {
  const camera = {position: [1.5, -2, 0.25], rotation: [0.5, 0.5, -0.5, 0.5], lens: kLens};
  const word = viewWord(camera);
  assert.equal(word, '1.5,-2,0.25,0.5,0.5,-0.5,0.5,51.282');
  const pose = poseOfWord(word, kInfo);
  assert.deepEqual(pose.position.toArray(), camera.position);
  assert.deepEqual(pose.rotation.toArray(), [0.5, -0.5, 0.5, 0.5]);  // x, y, z, w
  assert.equal(viewWord({...camera, lens: pose.lens}), word);
  for (const wrong of ['', '1,2,3', '1,2,3,1,0,0,0', '1,2,3,0,0,0,0,50', '1,2,3,1,0,0,0,0',
                       '1,2,x,1,0,0,0,50', '1,,3,1,0,0,0,50', '1,2,3,1,0,0,0,50,9'])
    assert.equal(poseOfWord(wrong, kInfo), null, wrong);
});

/** Opens a page of the export; its image is complete. */
async function open(query, script) {
  const opened = await openPage(site.browser, {origin: site.origin, width: 640, height: 480});
  if (script) await opened.page.addInitScript(script);
  await opened.page.goto(query.startsWith('http') ? query
                                                  : `${site.address}${query}`);
  await opened.page.waitForFunction(() => window.tessera);
  await opened.page.evaluate(() => window.tessera.settle());
  return opened;
}
async function middle(page) {
  await page.evaluate(() => window.tessera.settle());
  return readPng(await page.screenshot({clip: {x: 80, y: 70, width: 480, height: 200}}));
}

// Bugs put back: view= not read; the address left with cam=; each seen to fail.
test('a view that was dragged is in the address, and the copied link shows it', async () => {
  const {page, problems} = await open('?paused&t=1.2&cam=front', () => {
    Object.defineProperty(navigator, 'share', {value: undefined});
    Object.defineProperty(navigator, 'clipboard', {value: {
      writeText: async (text) => { window.copied = text; },
    }});
  });
  const first = await middle(page);
  await page.mouse.move(300, 200);
  await page.mouse.down();
  await page.mouse.move(340, 210, {steps: 3});
  await page.mouse.up();
  const turned = await middle(page);
  assert.ok(differing(first, turned) > 1000);
  await page.waitForURL(/view=/);
  assert.doesNotMatch(page.url(), /cam=/);
  await page.keyboard.press('Home');
  await page.evaluate(() => window.tessera.seek(1.5));
  const later = await middle(page);
  await page.locator('#share').click();
  await page.locator('#notice').waitFor();
  assert.equal(await page.locator('#notice').textContent(), 'Link copied');
  const again = await open(await page.evaluate(() => window.copied));
  const value = psnr(later, await middle(again.page));
  assert.ok(value >= 45, `${value} dB`);
  assert.equal(await again.page.locator('#camera').inputValue(), '-1');
  await again.page.keyboard.press('1');
  assert.doesNotMatch(again.page.url(), /view=/);
  for (const each of [page, again.page]) await each.close();
  expectClean(problems);
  expectClean(again.problems);
});

// Bugs put back: quotes of a title end the attribute; a page on a disk is said to be shared; each
// seen to fail.
test('the line that embeds a page, and what is said of one on a disk', async () => {
  const line = embedLine('https://a.b/c?t=1&cam=x', 'A "big" <room>');
  assert.match(line, /^<iframe src="https:\/\/a\.b\/c\?t=1&amp;cam=x" title="A &quot;big&quot; &lt;room>" /);
  assert.equal(imageName('a/b: c', 1.256), 'a b c 1.26 s.png');
  let copied = null;
  Object.defineProperty(globalThis, 'navigator', {configurable: true, value: {
    clipboard: {writeText: async (text) => { copied = text; }}}});
  assert.match(await share('file:///a/index.html', ''), /^Link copied, but this page lies on a disk/);
  copied = null;
  assert.match(await shareEmbed('file:///a/index.html', ''), /^Nothing copied/);
  assert.equal(copied, null);
  await shareEmbed('http://a.b/', 'x');
  assert.equal(copied, embedLine('http://a.b/', 'x'));
});

// Bug put back: the canvas read after the browser has taken its image; seen to fail.
test('the image on the screen is saved as a file', async () => {
  const {page, problems} = await open('?paused&t=1.25&cam=front&bg=ff0000');
  const shown = readPng(await page.locator('#picture').screenshot());
  await page.evaluate(() => document.activeElement.blur());
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('x')]);
  assert.match(download.suggestedFilename(), / 1\.25 s\.png$/);
  const saved = readPng(await download.path());
  assert.deepEqual([saved.width, saved.height], [640, 480]);
  assert.deepEqual([...saved.data.subarray(0, 3)], [255, 0, 0], 'the background of the address');
  const rows = {x: 100, y: 100, width: 300, height: 200};
  const part = readPng(await page.screenshot({clip: rows}));
  let different = 0;
  for (let y = 0; y < rows.height; ++y)
    for (let x = 0; x < rows.width; ++x)
      different += [0, 1, 2].some((c) => Math.abs(
          part.data[4 * (y * rows.width + x) + c] -
          saved.data[4 * ((y + rows.y) * saved.width + x + rows.x) + c]) > 2);
  assert.equal(different, 0);
  assert.ok(shown.width > 0);
  await page.close();
  expectClean(problems);
});

// Bug put back: the clipboard used where the system has a sheet; seen to fail.
test('the sheet of the system is used where there is one, and closing it gives no message', async () => {
  const {page, problems} = await open('?paused&cam=side', () => {
    navigator.share = async (data) => {
      window.shared = data;
      throw new DOMException('closed', 'AbortError');
    };
  });
  await page.keyboard.press('c');
  await page.waitForFunction(() => window.shared);
  assert.match(await page.evaluate(() => window.shared.url), /cam=side/);
  assert.ok(await page.locator('#notice').isHidden());
  await page.close();
  expectClean(problems);
});
