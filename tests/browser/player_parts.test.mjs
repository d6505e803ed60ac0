// Parts of the player that need no browser: the blocks that are loaded, the clock, keys and the
// address.
import assert from 'node:assert/strict';
import {setImmediate as turn} from 'node:timers/promises';
import {test} from 'node:test';
import {playerModules} from './player_modules.mjs';

const {Arrivals, BlockCache, Clock, PlayerError, actionOf, loadedShare, loadingLine, readUrl,
       withValues} =
    await playerModules('blocks', 'clock', 'keys', 'loading', 'player_error', 'url_state');

/** Ten segments of a tenth each and a block that is always seen; what was asked of it, in order. */
function cacheOf({budget = 1e9, loads = () => ({memory: 10})} = {}) {
  const log = [], pending = new Map();
  const spans = [{visible: [0, 1]},
                 ...Array.from({length: 10}, (_, k) => ({visible: [k / 10, (k + 1) / 10]}))];
  const cache = new BlockCache(spans, budget, {
    load: (i, signal) => {
      log.push(i);
      return new Promise((resolve, reject) => {
        pending.set(i, () => {
          pending.delete(i);
          try { resolve(loads(i)); } catch (error) { reject(error); }
        });
        signal.addEventListener('abort', () => {
          log.push(`abort ${i}`);
          pending.delete(i);
          reject(Object.assign(new Error('given up'), {name: 'AbortError'}));
        });
      });
    },
    release: () => log.push('release'),
    onChange: () => log.push('change'),
  });
  const finish = async () => {
    for (let round = 0; round < 50 && pending.size; ++round) {
      [...pending.values()].forEach((go) => go());
      await turn();
    }
  };
  return {cache, log, finish, asked: () => log.filter(Number.isInteger)};
}
const here = (cache) => [...Array(11).keys()].filter((i) => cache.get(i) !== undefined);

// Bug put back: `later` sorted the other way round, at(t) not first; each seen to fail.
test('the blocks of the current time are loaded first, then those ahead', async () => {
  const {cache, asked, finish} = cacheOf();
  cache.update({t: 0.25, ahead: 0.25, loop: true});
  assert.deepEqual(asked(), [0, 3, 4, 5]);  // four at once
  assert.ok(cache.waiting(0.25));
  await finish();
  assert.ok(!cache.waiting(0.25));
  assert.deepEqual(here(cache), [0, 3, 4, 5, 6]);
});

// Bug put back: distance() without the loop's way round; seen to fail.
test('around the end of a loop, and backwards', async () => {
  const looped = cacheOf(), once = cacheOf(), back = cacheOf();
  looped.cache.update({t: 0.95, ahead: 0.1, loop: true});
  once.cache.update({t: 0.95, ahead: 0.1, loop: false});
  back.cache.update({t: 0.25, ahead: -0.1, loop: false});
  for (const {finish} of [looped, once, back]) await finish();
  assert.deepEqual(here(looped.cache), [0, 1, 10]);
  assert.deepEqual(here(once.cache), [0, 10]);
  assert.deepEqual(here(back.cache), [0, 2, 3]);
});

// Bug put back: abort() left away; seen to fail.
test('requests that are no longer needed are cancelled', async () => {
  const {cache, log, finish} = cacheOf();
  cache.update({t: 0.25, ahead: 0, loop: false});
  cache.update({t: 0.75, ahead: 0, loop: false});
  assert.deepEqual(log, [0, 3, 'abort 3', 8]);
  await finish();
  assert.deepEqual(here(cache), [0, 8]);
});

// Bug put back: eviction of the newest; blocks of the current time not kept; each seen to fail.
test('the least recently used block is evicted when memory is short', async () => {
  const {cache, finish} = cacheOf({budget: 30});
  for (const t of [0.05, 0.15, 0.25, 0.35]) {
    cache.update({t, ahead: 0, loop: false});
    await finish();
  }
  assert.deepEqual(here(cache), [0, 3, 4]);
  const tight = cacheOf({budget: 1});
  tight.cache.update({t: 0.35, ahead: 0, loop: false});
  await tight.finish();
  assert.deepEqual(here(tight.cache), [0, 4]);  // what is drawn stays, whatever it costs
});

// Bug put back: retryAt of damaged blocks as of networks; seen to fail.
test('a damaged block is named and not asked for again, a network is', async (t) => {
  let now = 1000;
  const clock = Date.now;
  Date.now = () => now;
  t.after(() => { Date.now = clock; });
  for (const [trouble, times] of [['data', 1], ['network', 2]]) {
    const {cache, asked, finish} = cacheOf({loads: (i) => {
      if (i === 3) throw new PlayerError('a.bin: is damaged; copy it again', trouble);
      return {memory: 10};
    }});
    cache.update({t: 0.25, ahead: 0, loop: false});
    await finish();
    assert.equal(cache.trouble(0.25), 'a.bin: is damaged; copy it again');
    assert.equal(cache.trouble(0.75), null);
    assert.ok(!cache.waiting(0.25), 'playback continues with the loaded blocks');
    now += 6000;
    cache.update({t: 0.25, ahead: 0, loop: false});
    assert.equal(asked().filter((i) => i === 3).length, times, trouble);
  }
});

/** A clock on a wall that the test moves. */
function clockOf(duration, sound = null) {
  const wall = {now: 100};
  return {wall, clock: new Clock(duration, () => wall.now, sound)};
}

// Bug put back: rate left away, loop without the remainder, seek without limits; each seen to fail.
test('the clock is the wall, however seldom it is asked', () => {
  const {clock, wall} = clockOf(3);
  clock.play();
  wall.now += 1;
  assert.equal(clock.now(), 1);
  clock.setRate(0.5);
  wall.now += 1;
  assert.equal(clock.now(), 1.5);
  wall.now += 10;  // 5 s of clip: twice past the end
  assert.ok(Math.abs(clock.now() - 0.5) < 1e-9);
  clock.pause();
  wall.now += 7;
  assert.ok(Math.abs(clock.now() - 0.5) < 1e-9);
  clock.seek(99);
  assert.equal(clock.now(), 3);
});

// Bug put back: hold() that only stops drawing; seen to fail.
test('time stands while data is awaited, and stops at the end without a loop', () => {
  const {clock, wall} = clockOf(3);
  clock.loop = false;
  clock.play();
  clock.hold(true);
  wall.now += 2;
  assert.equal(clock.now(), 0);
  clock.hold(false);
  wall.now += 5;
  assert.equal(clock.now(), 3);
  assert.ok(!clock.playing);
  clock.play();  // again from the beginning
  assert.equal(clock.now(), 0);
  const still = clockOf(0).clock;
  still.play();
  assert.deepEqual([still.now(), still.playing], [0, false]);
});

// Bug put back: now() by the wall alone; seen to fail.
test('sound is the clock where there is sound', async () => {
  const sound = {currentTime: 0, playbackRate: 1, paused: true, ended: false, seeking: false,
                 play: async () => { sound.paused = false; }, pause: () => { sound.paused = true; }};
  const {clock, wall} = clockOf(10, sound);
  clock.play();
  wall.now += 2;
  sound.currentTime = 1.8;  // a slow sound card
  assert.equal(clock.now(), 1.8);
  clock.seek(5);
  assert.equal(sound.currentTime, 5);
  sound.ended = true;  // shorter than the clip: the wall clock continues
  wall.now += 1;
  assert.equal(clock.now(), 6);
  clock.pause();
  assert.ok(sound.paused);
});

// Bug put back: keys of cameras from 0; seen to fail.
test('keys', () => {
  assert.deepEqual(actionOf(' '), {do: 'toggle'});
  assert.deepEqual(actionOf('ArrowLeft'), {do: 'step', frames: -1});
  assert.deepEqual(actionOf('1'), {do: 'camera', index: 0});
  assert.deepEqual(actionOf(']'), {do: 'rate', steps: 1});
  assert.deepEqual(actionOf('x'), {do: 'save'});
  assert.equal(actionOf('q'), null);
});

// Bug put back: ?paused without a value as no; seen to fail.
test('the address', () => {
  assert.deepEqual(readUrl('?t=1.5&cam=cam%2001&rate=0.5&paused&ui=0'),
                   {scene: null, seconds: 1.5, camera: 'cam 01', view: null, rate: 0.5, paused: true,
                    loop: true, part: null, path: false, background: null, panels: false});
  const shown = readUrl('?part=0.5-1.25&bg=ff8000');
  assert.deepEqual(shown.part, {from: 0.5, to: 1.25});
  assert.deepEqual(shown.background, [255, 128, 0]);
  assert.equal(readUrl('?part=2-1&bg=red').part, null);
  assert.equal(readUrl('?part=2-1&bg=red').background, null);
  assert.deepEqual(readUrl('?t=soon&rate=-1&loop=0&scene=a/b.t4d'),
                   {scene: 'a/b.t4d', seconds: null, camera: null, view: null, rate: null,
                    paused: false, loop: false, part: null, path: false, background: null,
                    panels: true});
  assert.equal(withValues('http://a/b?t=1&x=2', {t: '3', x: null}), 'http://a/b?t=3');
});

// Bug put back: bytes of all blocks counted, those fetched ahead too; seen to fail.
test('the line of loading is by the bytes that the image in view needs', () => {
  let progress;
  const arrivals = new Arrivals([3e6, 1e6, 5e6], () => { progress = arrivals.of([0, 1]); });
  assert.equal(loadingLine({bytes: 0, needed: 0}), 'Loading');
  arrivals.begin(0);
  assert.equal(loadingLine(progress), 'Loading: 0 % of 4.0 MB');
  arrivals.add(2, 5e6);  // fetched ahead
  arrivals.add(0, 1e6);
  assert.equal(loadingLine(progress), 'Loading: 25 % of 4.0 MB');
  assert.equal(loadedShare(progress), 0.25);
  arrivals.begin(0);  // once more
  arrivals.end(0);
  assert.equal(loadingLine(progress), 'Loading: 75 % of 4.0 MB');
  arrivals.end(1);
  assert.equal(loadingLine(progress), 'Preparing the first image');
  assert.equal(loadedShare(progress), 1);
  const unknown = new Arrivals([null], () => { progress = unknown.of([0]); });
  unknown.add(0, 250000);
  assert.equal(loadingLine(progress), 'Loading: 250 kB');
  assert.equal(loadedShare(progress), 0);
  unknown.end(0);
  assert.equal(loadingLine(progress), 'Preparing the first image');
});
