// The package tessera4d-loader: built with its types as npm would publish it, then its example page
// in a browser, whose images are compared with those of the program.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {cpSync, existsSync, mkdirSync, readFileSync, renameSync, symlinkSync, writeFileSync}
  from 'node:fs';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {expectClean, fixture, launchBrowser, openPage, packagesFolder, psnr, readPng, scratchFolder,
        serve, shot, tessera} from './harness.mjs';
import {bytesOf, evenWindows, joinWindows, readFolder, writeFolder} from './windowed_file.mjs';

const kTimes = [0, 0.35, 1];
const kModels = {pairs: fixture.model, carried: fixture.carried};
/** Three windows that all play the model, and times with the window that is drawn: two at a border. */
const kWindows = evenWindows(3).map((window) => ({...window, tint: null, light: undefined}));
const kSeen = [[0, 0], [1 / 3 - 1e-7, 0], [1 / 3, 1], [0.45, 1], [1, 2]];
const tauOf = ([t, i], {time: [lo, hi]} = kWindows[i]) => (t - lo) / (hi - lo);
const folder = scratchFolder(), player = join(folder, 'player'), loader = join(player, 'loader');
const source = join(dirname(fileURLToPath(import.meta.url)), '../../tools/web');
let browser, server;

/** The package, built from the sources with the player's packages. */
function build() {
  mkdirSync(player);
  for (const name of ['player', 'loader', 'tsconfig.json', 'package.json'])
    cpSync(join(source, name), join(player, name), {recursive: true});
  symlinkSync(join(process.env.TESSERA_PLAYER_WORK, 'node_modules'), join(player, 'node_modules'));
  // the package's own `build`, by Node.js: packages come without the links that npm makes
  for (const command of JSON.parse(readFileSync(join(loader, 'package.json'))).scripts.build.split(' && ')) {
    const [name, ...options] = command.split(' ');
    const program = {vite: 'vite/bin/vite.js', tsc: 'typescript/bin/tsc'}[name];
    execFileSync(process.execPath, [join(player, 'node_modules', program), ...options],
                 {cwd: loader, stdio: 'inherit'});
  }
}

before(async () => {
  build();
  const example = join(loader, 'example/index.html');
  writeFileSync(example, readFileSync(example, 'utf8').replace(
      /https:\/\/cdn\.jsdelivr\.net\/npm\/((?:@\w+\/)?\w+)@[\d.]+\//g, '/packages/$1/'));
  for (const [name, model] of Object.entries(kModels)) {
    const out = join(folder, name);
    tessera('export', model, '--format', 'tessera', '--single', '--cameras', fixture.cameras, '-o', out);
    tessera('export', model, '--format', 'tessera', '--cameras', fixture.cameras,
            '-o', join(loader, 'example', name));
    renameSync(join(out, 'scene.t4d'), join(loader, 'example', `${name}.t4d`));
    for (const t of kTimes)
      tessera('render', model, '--cameras', fixture.cameras, '--time', t,
              '-o', join(folder, `render_${name}_${t}`));
  }
  const long = joinWindows(readFolder(join(loader, 'example/pairs')), kWindows, 15);
  writeFileSync(join(loader, 'example/long.t4d'), bytesOf(long));
  mkdirSync(join(loader, 'example/long'));
  writeFolder(long, join(loader, 'example/long'));
  for (const seen of kSeen)
    tessera('render', fixture.model, '--cameras', fixture.cameras, '--time', tauOf(seen),
            '-o', join(folder, `render_long_${seen[0]}`));
  server = await serve({'/': loader, '/packages/': packagesFolder});
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  await server?.close();
});

async function open(scene) {
  const opened = await openPage(browser, server);
  await opened.page.setViewportSize({width: fixture.width, height: fixture.height});
  await opened.page.goto(`${server.origin}/example/index.html?scene=${scene}`);
  return opened;
}

/** In the page: the example stops, and draws what the file's first camera sees of the turned object. */
async function drawn(page, t) {
  await page.waitForFunction(() => window.example);
  await page.evaluate(async (share) => {
    const {tessera, camera, renderer, scene, spark} = window.example;
    renderer.setAnimationLoop(null);
    document.querySelector('p').textContent = '';
    tessera.quaternion.set(0.6, 0, 0.8, 0);
    tessera.updateMatrixWorld();
    const {position, rotation: [w, x, y, z], fx, fy, cx, cy, width, height} = tessera.cameras[0];
    const [near, far] = [0.05, 1000];
    camera.projectionMatrix.set(2 * fx / width, 0, 1 - 2 * cx / width, 0, 0, 2 * fy / height,
                                2 * cy / height - 1, 0, 0, 0, (far + near) / (near - far),
                                2 * far * near / (near - far), 0, 0, -1, 0);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
    tessera.localToWorld(camera.position.set(...position));
    camera.quaternion.set(x, y, z, w).premultiply(tessera.quaternion)
        .multiply(camera.quaternion.clone().set(1, 0, 0, 0));
    camera.updateMatrixWorld();
    const ready = () => !tessera.waiting && !spark.sorting && !spark.sortDirty &&
        spark.display === spark.current;
    for (let quiet = 0, tries = 0; quiet < 3 && tries < 600; ++tries) {
      tessera.update(share * tessera.duration, camera, {ahead: 0});
      renderer.render(scene, camera);
      await new Promise(requestAnimationFrame);
      quiet = ready() ? quiet + 1 : 0;
    }
  }, t);
  return shot(page);
}

test('the package holds one module without three.js or Spark, and its types', () => {
  const module = readFileSync(join(loader, 'dist/tessera4d-loader.js'), 'utf8');
  assert.ok(module.length < 100000, `${module.length}`);
  const {exports} = JSON.parse(readFileSync(join(loader, 'package.json')));
  assert.ok(existsSync(join(loader, exports['.'].types)), 'types');
  assert.ok(existsSync(join(loader, exports['.'].import)), 'module');
});

// Bug put back: the eye stays in the world instead of the object's axes; seen to fail.
for (const name of Object.keys(kModels))
  for (const scene of [`${name}.t4d`, `${name}/manifest.json`])
    test(`${scene}: the images of the program`, async (context) => {
      const {page, problems} = await open(scene);
      for (const t of kTimes) {
        const image = await drawn(page, t);
        const value = psnr(image, readPng(join(folder, `render_${name}_${t}`, 'front.png')));
        context.diagnostic(`t = ${t}: ${value.toFixed(1)} dB`);
        assert.ok(value >= 40, `t = ${t}: ${value.toFixed(1)} dB`);
      }
      await page.close();
      expectClean(problems);
    });

for (const scene of ['long.t4d', 'long/manifest.json'])
  test(`${scene}: windows of a long clip, each in its own time`, async (context) => {
    const {page, problems} = await open(scene);
    for (const [t, i] of kSeen) {
      const image = await drawn(page, t);
      const value = psnr(image, readPng(join(folder, `render_long_${t}`, 'front.png')));
      context.diagnostic(`t = ${t}: ${value.toFixed(1)} dB`);
      assert.ok(value >= 40, `t = ${t} is not window ${i}: ${value.toFixed(1)} dB`);
    }
    const {gaussians, duration} = await page.evaluate(
        () => ({gaussians: window.example.tessera.gaussians, duration: window.example.tessera.duration}));
    assert.deepEqual([gaussians, duration], [fixture.fixed + fixture.moving, 15]);
    await page.close();
    expectClean(problems);
  });

test('a file that is none is named in the page', async () => {
  writeFileSync(join(loader, 'example/none.t4d'), 'this is none');
  const {page} = await open('none.t4d');
  await page.waitForFunction(() => document.querySelector('p').textContent !== '');
  assert.match(await page.textContent('p'), /none\.t4d: no Tessera 4D file/);
  await page.close();
});
