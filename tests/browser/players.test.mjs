// Every static export in the players it is written for: the number of splats and the image against
// that of `tessera render`. Source: docs/reference/splat-formats.md.
import assert from 'node:assert/strict';
import {copyFileSync, mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath} from 'node:url';

import {expectClean, fixture, launchBrowser, openPage, packagesFolder, psnr, readPng,
        scratchFolder, serve, shot, tessera} from './harness.mjs';

const folder = scratchFolder(), files = join(folder, 'files');
const kTime = 0.5, kShine = 3;  // the fixture's view-dependent colours are faint
const kExtensions = {
  ply: '.ply', compressed: '.compressed.ply', spz3: '.spz', spz4: '.spz', splat: '.splat',
  glb: '.glb', sog: '.sog',
};
// x, y, z, w of the rotation that shows a file in the world of the .ply
const kAsIs = [0, 0, 0, 1], kAboutX = [1, 0, 0, 0], kAboutZ = [0, 0, 1, 0];

const kLeast = 35;  // dB

/** Which files a player shows and how each is turned. */
const kPlayers = {
  spark: {files: {ply: kAsIs, compressed: kAsIs, spz3: kAboutX, splat: kAsIs, sog: kAsIs}},
  playcanvas: {files: {ply: kAsIs, compressed: kAsIs, sog: kAsIs}},
  // ends splats at 2σ, where others go to 1/255: `narrow` has our renderer do the same
  three: {narrow: true,
          files: {ply: kAsIs, spz3: kAboutX, spz4: kAboutX, splat: kAsIs, glb: kAboutZ}},
  gsplat: {files: {splat: kAsIs}},
};

let browser, server, count;
const drawn = {}, cameras = {};

/** Our image of a file seen by every camera of `path` → drawn[name]. */
function render(model, path, name, time) {
  const out = join(folder, name);
  tessera('render', model, '--cameras', path, '--time', time, '-o', out);
  for (const camera of Object.keys(cameras))
    drawn[`${name}/${camera}`] = readPng(join(out, `${camera}.png`));
}

/** A 3DGS .ply with all but the first harmonic times `factor`. */
function withHarmonics(bytes, factor) {
  const mark = 'end_header\n', start = bytes.indexOf(mark) + mark.length, result = Buffer.from(bytes);
  const names = bytes.toString('latin1', 0, start).match(/(?<=property float )\w+/g);
  for (let place = start, k = 0; place < bytes.length; place += 4, k = (k + 1) % names.length)
    if (names[k].startsWith('f_rest')) result.writeFloatLE(factor * bytes.readFloatLE(place), place);
  return result;
}

/** The same as a model that our renderer ends at 2σ, as three.js does. */
function narrowed(ply, name) {
  const out = join(folder, `model_${name}`), narrow = join(folder, `${name}.ply`);
  tessera('export', ply, '--format', 'model', '-o', out);
  const model = readFileSync(join(out, 'model.ply'), 'latin1');
  assert.match(model, /comment truncation_sigma /);
  const ends = model.replace(/comment truncation_sigma .*/, 'comment truncation_sigma 2')
                   .replace(/comment truncation_by_falloff .*/, 'comment truncation_by_falloff 1');
  writeFileSync(narrow, ends, 'latin1');
  return narrow;
}

/** frame_0000 of an export, and its count. */
function exported(model, format, extension, ...more) {
  const out = join(folder, `export_${exported.count++}`);
  tessera('export', model, '--format', format, '-o', out, ...more);
  count = JSON.parse(readFileSync(join(out, 'manifest.json'))).frames[0].gaussians;
  return join(out, `frame_0000${extension}`);
}
exported.count = 0;

before(async () => {
  mkdirSync(files, {recursive: true});
  const frame = readFileSync(exported(fixture.model, 'ply', '.ply', '--time', kTime));
  const model = join(folder, 'shining.ply'), plain = join(folder, 'plain.ply');
  writeFileSync(model, withHarmonics(frame, kShine));
  writeFileSync(plain, withHarmonics(frame, 0));
  for (const [name, extension] of Object.entries(kExtensions)) {
    const version = name.startsWith('spz') ? ['--spz-version', name[3]] : [];
    copyFileSync(exported(model, name.replace(/\d/, ''), extension, ...version),
                 join(files, name + extension));
  }
  const path = JSON.parse(readFileSync(fixture.cameras));
  for (const frame of path.frames)
    cameras[frame.file_path] = {matrix: frame.transform_matrix, fx: path.fl_x, fy: path.fl_y,
                                width: path.w, height: path.h};
  render(model, fixture.cameras, 'ply', kTime);
  render(plain, fixture.cameras, 'plain', kTime);
  for (const [name, of] of Object.entries({narrow_ply: model, narrow_plain: plain}))
    render(narrowed(of, name), fixture.cameras, name, kTime);
  server = await serve({
    '/': join(dirname(fileURLToPath(import.meta.url)), 'pages'), '/packages/': packagesFolder,
    '/files/': files,
  });
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  await server?.close();
});

async function openPlayer(name) {
  const opened = await openPage(browser, server);
  await opened.page.goto(`${server.origin}/${name}.html`);
  await opened.page.waitForFunction(() => window.ready, null, {timeout: 30000});
  return opened;
}

/** {count, image} of a file in a page. */
async function shown(page, request) {
  const splats = await page.evaluate((asked) => window.show(asked), request);
  return {splats, image: await shot(page)};
}

function expectAlike(context, image, other, what) {
  const db = psnr(image, other);
  context.diagnostic(`${what}: ${db.toFixed(1)} dB`);
  assert.ok(db >= kLeast, `${what}: ${db.toFixed(1)} dB, wanted ${kLeast}`);
}

// Bugs put back: rotation as x, y, z, w in each format; axes of .spz and .glb as those of .ply;
// opacity of .splat not scaled by 255; SH by coefficient in .ply. Seen to fail.
for (const [player, {narrow, files: shows}] of Object.entries(kPlayers))
  test(`${player}: ${Object.keys(shows).join(', ')}`, async (context) => {
    const ply = {}, {page, problems} = await openPlayer(player);
    for (const [name, turn] of Object.entries(shows))
      for (const camera of ['front', 'side']) {
        const {splats, image} = await shown(
            page, {url: `/files/${name}${kExtensions[name]}`, camera: cameras[camera], turn});
        const plain = name === 'splat';  // no colours that depend on the view
        const ours = `${narrow ? 'narrow_' : ''}${plain ? 'plain' : 'ply'}/${camera}`;
        assert.equal(splats, count, name);
        expectAlike(context, image, drawn[ours], `${name} ${camera} against our renderer`);
        if (plain) continue;
        ply[camera] ??= image;
        expectAlike(context, image, ply[camera], `${name} ${camera} against .ply here`);
      }
    expectClean(problems);
    await page.close();
  });

test('axes: without the turn that the formats ask for, the image is another', async () => {
  for (const [player, names] of Object.entries({spark: ['spz3'], three: ['spz4', 'glb']})) {
    const {page} = await openPlayer(player);
    for (const name of names) {
      const {image} = await shown(page, {url: `/files/${name}${kExtensions[name]}`,
                                           camera: cameras.front, turn: kAsIs});
      assert.ok(psnr(image, drawn['ply/front']) < 25, `${player} ${name}`);
    }
    await page.close();
  }
});
