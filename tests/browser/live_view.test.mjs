// `tessera view` of a training in progress: the page shows and updates the model, PSNR rises, and
// the page stops the training. Source: docs/reference/run-folder.md.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {existsSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {differing, expectClean, launchBrowser, openPage, readPng, scratchFolder, tessera} from './harness.mjs';

const folder = scratchFolder();
const place = (...names) => join(folder, ...names);
const run = place('out', 'run');
let browser, training, view, address;

/** `tessera …words` until it ends. */
function start(...words) {
  const child = spawn(process.env.TESSERA_PROGRAM, words.map(String), {stdio: ['ignore', 'pipe', 'pipe']});
  const told = {out: '', err: '', code: null};
  child.stdout.on('data', (bytes) => (told.out += bytes));
  child.stderr.on('data', (bytes) => (told.err += bytes));
  told.ended = new Promise((resolve) => child.on('exit', (code) => resolve((told.code = code))));
  told.kill = () => child.kill('SIGKILL');
  return told;
}

// Training and page share the cores with whatever else runs: a limit says that nothing happens.
const kLimit = 240_000;  // ms

async function until(condition, what) {
  for (const end = Date.now() + kLimit; Date.now() < end;) {
    const value = await condition();
    if (value) return value;
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  assert.fail(`${what}: not within four minutes\n${training.err}\n${view?.err ?? ''}`);
}

before(async () => {
  tessera('synth', 'object', '-o', place('capture'), '--layout', 'dnerf', '--frames', 24, '--held-out-frames', 4, '--width', 96,
          '--height', 96);
  training = start('train', place('capture'), '-o', run, '--preset', 'fast', '--init-points', 3000,
                   '--threads', 1, '--iterations', 200000);
  await until(() => existsSync(join(run, 'log.jsonl')), 'the training begins');
  view = start('view', place('out'), '--no-browser', '--json');
  address = JSON.parse(await until(() => view.out.endsWith('\n') && view.out, 'the address')).url;
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  view?.kill();
  training?.kill();
});

async function opened(size) {
  const page = await openPage(browser, {origin: new URL(address).origin, ...size});
  page.page.setDefaultTimeout(kLimit);
  await page.page.goto(address);
  await page.page.waitForFunction(
      () => !document.getElementById('player').hidden && /step \d/.test(document.body.innerText),
      null, {timeout: kLimit});
  return page;
}

const psnrOf = (page) => page.evaluate(() => Number(/([\d.]+) dB/.exec(document.getElementById('numbers').innerText)?.[1]));
const shownStep = (page) => page.evaluate(
    () => Number(/model shown\s+step ([\d,]+)/.exec(document.getElementById('numbers').innerText)?.[1].replace(/,/g, '')));

async function pictureOf(page, name) {
  await page.evaluate(() => document.getElementById('player').contentWindow.tessera.settle());
  const bytes = await page.screenshot();
  writeFileSync(place(name), bytes);
  return readPng(await page.locator('#player').screenshot());
}

// Bugs put back: replace() does nothing; scores of the first snapshot for all; each seen to fail.
test('the model of a running training is renewed, and PSNR rises', async () => {
  const {page, problems} = await opened({width: 1280, height: 720});
  const step = await until(() => shownStep(page), 'a first model');
  const first = await pictureOf(page, 'first_1280.png');
  const early = await until(() => psnrOf(page), 'a first score');
  await until(async () => (await shownStep(page)) > step, 'the next model');
  await until(async () => (await psnrOf(page)) > early, 'a better score');
  assert.ok(differing(first, await pictureOf(page, 'later_1280.png')) > 0, 'another image');
  const inside = page.frameLocator('#player');
  await inside.locator('#compare').click();
  await page.waitForFunction(() => document.getElementById('player').contentDocument
      .getElementById('truth')?.naturalWidth === 96);
  await pictureOf(page, 'truth_1280.png');
  assert.equal(problems.foreign.length, 0);
  expectClean(problems);
  await page.close();
});

// Bug put back: MiB, where the chart below has MB; seen to fail.
test('a phone sees the model and the numbers', async () => {
  const {page, problems} = await opened({width: 390, height: 844});
  assert.match(await page.innerText('#numbers'), /memory\s+[\d.]+ MB/);
  await pictureOf(page, 'phone_390.png');
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(wide <= 390, `${wide} pixels wide`);
  expectClean(problems);
  await page.close();
});

// Finds: no command where it has stopped.
test('the page stops the training, which keeps a checkpoint, and says how it is resumed', async () => {
  const {page, problems} = await opened({width: 1280, height: 720});
  const status = (word) => page.waitForFunction(
      (part) => document.getElementById('status').innerText.includes(part), word);
  await page.click('#stop');
  assert.equal(await training.ended, 75, training.err);
  assert.ok(existsSync(join(run, 'checkpoint.ckpt')));
  await status('stopped');
  await status('of 200,000 steps');
  assert.match(await page.innerText('#resume'), /tessera train .* --resume/);
  await page.screenshot({path: place('stopped_1280.png')});
  // the training removes its snapshots as it stops, of which the page may load one at that time
  problems.errors = problems.errors.filter((text) => !text.includes('404'));
  expectClean(problems);
  await page.close();
});
