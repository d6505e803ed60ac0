// The player's page with a ten-minute file of 120 windows over a slow line: what a start costs, seeks,
// borders between windows, play over a border, and memory. References are files of version 1 of one
// window each.
import assert from 'node:assert/strict';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {differing, expectClean, fixture, launchBrowser, openPage, psnr, scratchFolder, shot, tessera} from
    './harness.mjs';
import {serveSlowly} from './throttled_server.mjs';
import {bytesOf, evenWindows, heavyEntry, joinWindows, readFolder, windowAlone} from './windowed_file.mjs';

const kWindows = 120, kLength = 5, kSeconds = kWindows * kLength;
const kFirstRead = 1 << 18, kAhead = 2.5;  // bytes, seconds
const kHeavy = 21;  // windows of the file that is larger than memory
const kCompared = [0, 1, 59, 60, 118, 119];  // windows that are there alone, too
const folder = scratchFolder(), place = (name) => join(folder, name);
const windows = evenWindows(kWindows, kLength);
let browser, server, clip, long, size;

function write(name, bytes) {
  writeFileSync(place(name), bytes);
  return bytes.length;
}

/** Windows of which each takes 25 MB of memory: in all twice the budget of a small machine. */
function heavyFile() {
  const light = clip.entries.filter(({info}) => info.kind === 'static');
  const entries = [...light, ...[0, 1, 2, 3].map(() => heavyEntry(131072))];
  return bytesOf(joinWindows({...clip, entries}, evenWindows(kHeavy, kLength), kHeavy * kLength));
}

before(async () => {
  tessera('export', fixture.model, '--format', 'tessera', '--segment', '0.5', '--cameras', fixture.cameras,
          '-o', place('clip'));
  clip = readFolder(place('clip'));
  long = joinWindows(clip, windows, kSeconds);
  size = write('long.t4d', bytesOf(long));
  write('heavy.t4d', heavyFile());
  const files = {'/index.html': join(process.env.TESSERA_PLAYER_WORK, '../player.html'),
                 '/long.t4d': place('long.t4d'), '/heavy.t4d': place('heavy.t4d')};
  for (const i of kCompared) {
    write(`window${i}.t4d`, windowAlone(clip, windows[i]));
    files[`/window${i}.t4d`] = place(`window${i}.t4d`);
  }
  server = await serveSlowly(files, {bytesPerSecond: 400e3, latency: 150});
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  await server?.close();
});

/** Opens a scene; its first image is complete. */
async function open(scene, query, {prepare, ...more} = {}) {
  const opened = await openPage(browser, {origin: server.origin, ...more});
  if (prepare) await opened.page.addInitScript(prepare);
  await opened.page.goto(`${server.origin}/index.html?scene=${scene}&cam=front&${query}`);
  await opened.page.waitForFunction(() => window.tessera);
  await opened.page.evaluate(() => window.tessera.settle());
  return opened;
}
async function close({page, problems}) {
  await page.close();
  expectClean(problems);
}

const seek = (page, seconds) => page.evaluate((s) => {
  window.tessera.seek(s);
  return window.tessera.settle();
}, seconds);
async function imageAt(page, seconds) {
  await seek(page, seconds);
  return shot(page);
}
/** What window i alone shows at t of the long clip. */
const tauOf = (i, t) => (t - windows[i].time[0]) / (windows[i].time[1] - windows[i].time[0]);

/** Images of windows alone: of [[window, seconds], …], ascending. */
async function aloneAt(asked) {
  const images = [];
  let opened, shown;
  for (const [i, seconds] of asked) {
    if (i !== shown) {
      if (opened) await close(opened);
      opened = await open(`window${i}.t4d`, 'ui=0&paused');
      shown = i;
    }
    images.push(await imageAt(opened.page, fixture.seconds * tauOf(i, seconds / kSeconds)));
  }
  await close(opened);
  return images;
}

/** Bytes of blocks that are seen between two times. */
function bytesSeen(from, to) {
  return long.blocks.filter(({info: {visible}}) => visible[0] <= to / kSeconds && visible[1] >= from / kSeconds)
      .reduce((sum, {bytes}) => sum + bytes.length, 0);
}
/** Bytes that the line has sent since a place in its list. */
const sentSince = (from) => server.sent.slice(from).reduce((sum, {bytes}) => sum + bytes, 0);

// Bug put back: the whole file fetched at the start; seen to fail.
test('a start costs the manifest, the static set and what is seen soon, not the file', async (t) => {
  const manifest = JSON.stringify(long.manifest).length;
  t.diagnostic(`${long.blocks.length} blocks, ${size} bytes, of which ${manifest} of the manifest`);
  for (const [query, ahead] of [['paused&t=302', 0], ['t=302', kAhead]]) {
    const from = server.sent.length;
    const opened = await open('long.t4d', `ui=0&${query}`);
    const [bytes, requests] = [sentSince(from), server.sent.length - from];
    const reached = await opened.page.evaluate(() => window.tessera.time());
    const most = kFirstRead + bytesSeen(302, reached + ahead);
    t.diagnostic(`${query}: ${requests} requests, ${bytes} bytes of at most ${most}`);
    assert.ok(bytes <= most, `${query}: ${bytes} bytes, at most ${most}`);
    assert.ok(bytes < size / 8, `${query}: ${bytes} bytes of ${size}`);
    assert.equal(server.sent.slice(from).filter(({first}) => first === 0).length, 1, 'reads of the manifest');
    await close(opened);
  }
});

// Bug put back: a closed interval of cores; seen to fail.
test('a seek to anywhere and to borders shows one window, as its file alone', async (t) => {
  const times = [[0, 0], [0, 4.99999], [1, 5], [1, 7.3], [59, 299.5], [59, 299.99999], [60, 300],
                 [118, 594.99999], [119, 595], [119, 600]];
  const alone = await aloneAt(times);
  const opened = await open('long.t4d', 'ui=0&paused');
  // neither forwards nor backwards
  for (const k of [9, 3, 6, 5, 0, 8, 1, 2, 7, 4]) {
    const [i, seconds] = times[k];
    const from = server.sent.length;
    const image = await imageAt(opened.page, seconds);
    const value = psnr(image, alone[k]);
    t.diagnostic(`${seconds} s, window ${i}: ${value.toFixed(1)} dB, ${server.sent.length - from} requests`);
    assert.ok(value >= 50, `${seconds} s is not window ${i} alone: ${value.toFixed(1)} dB`);
    assert.ok(sentSince(from) <= bytesSeen(seconds - 0.01, seconds + 0.01), 'bytes of a seek');
  }
  assert.ok(differing(alone[5], alone[6], 30) > 500, 'neighbours differ');
  await close(opened);
});

// Bug put back: nothing fetched ahead of a border; seen to fail.
test('play over a border does not stop', async (t) => {
  const opened = await open('long.t4d', 'ui=0&t=296.5&paused');
  const ran = await opened.page.evaluate(async () => {
    window.tessera.play();
    await new Promise((done) => setTimeout(done, 1500));  // what lies ahead is on its way
    let longest = 0, [last, lastWall] = [window.tessera.time(), performance.now()];
    const [begin, wall] = [last, lastWall];
    while (window.tessera.time() < 302) {
      await new Promise(requestAnimationFrame);
      const [now, nowWall] = [window.tessera.time(), performance.now()];
      longest = Math.max(longest, (nowWall - lastWall) / 1000 - (now - last));
      [last, lastWall] = [now, nowWall];
    }
    return {longest, lag: (performance.now() - wall) / 1000 - (window.tessera.time() - begin)};
  });
  t.diagnostic(`behind the wall clock by ${ran.lag.toFixed(3)} s, in one frame ${ran.longest.toFixed(3)} s`);
  assert.ok(ran.lag < 0.1, `${ran.lag} s behind`);
  await close(opened);
});

/** Runs in the page before its own script: window.textureBytes() are those of the textures that live. */
function countTextures() {
  Object.defineProperty(navigator, 'deviceMemory', {get: () => 4});
  const sizes = new Map();
  const bound = new Map();
  const proto = WebGL2RenderingContext.prototype;
  const {bindTexture, texStorage3D, texImage3D, deleteTexture} = proto;
  proto.bindTexture = function(target, texture) {
    bound.set(target, texture);
    return bindTexture.call(this, target, texture);
  };
  proto.texStorage3D = function(target, levels, format, w, h, d) {
    sizes.set(bound.get(target), 16 * w * h * d);
    return texStorage3D.call(this, target, levels, format, w, h, d);
  };
  proto.texImage3D = function(...words) {
    sizes.set(bound.get(words[0]), 16 * words[3] * words[4] * words[5]);
    return texImage3D.apply(this, words);
  };
  proto.deleteTexture = function(texture) {
    sizes.delete(texture);
    return deleteTexture.call(this, texture);
  };
  window.textureBytes = () => [...sizes.values()].reduce((sum, bytes) => sum + bytes, 0);
}

// Bug put back: blocks that are not seen any more not freed; seen to fail.
test('seeks through a file that is larger than memory keep the budget', async (t) => {
  const opened = await open('heavy.t4d', 'ui=0&paused', {prepare: countTextures});
  const held = await opened.page.evaluate(() => window.textureBytes());
  let most = 0;
  for (let k = 0; k < kHeavy; ++k) {
    await seek(opened.page, ((k * 8) % kHeavy) * kLength + 2);
    most = Math.max(most, await opened.page.evaluate(() => window.textureBytes()));
  }
  const budget = 256 << 20, slack = 64 << 20;  // what Spark holds itself, and blocks in flight
  t.diagnostic(`textures: ${(held / 2 ** 20).toFixed(0)} MiB at first, at most ${(most / 2 ** 20).toFixed(0)} MiB`);
  assert.ok(most <= budget + held + slack, `${most} bytes of textures`);
  assert.ok(most > budget / 2, 'the file is large enough to tell');
  await close(opened);
});
