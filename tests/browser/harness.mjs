// Shared parts of the browser tests: the program, one Chromium, a file server, screenshots and
// their differences, and a list of the errors of a page.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {createReadStream, mkdirSync, readFileSync, rmSync, statSync} from 'node:fs';
import {createServer} from 'node:http';
import {createRequire} from 'node:module';
import {extname, join, normalize, sep} from 'node:path';

/** A folder or program that CTest names. */
function named(variable) {
  const value = process.env[variable];
  if (!value) throw new Error(`${variable} is not set; run these tests through ctest -L browser`);
  return value;
}

export const packagesFolder = join(named('TESSERA_BROWSER_PACKAGES'), 'node_modules');
/** require() of the pinned packages. */
export const packages = createRequire(join(packagesFolder, 'harness.cjs'));
const {PNG} = packages('pngjs');

/** Files of fixture_model.cpp. */
export const fixture = {
  folder: named('TESSERA_FIXTURE'),
  model: join(named('TESSERA_FIXTURE'), 'model.ply'),
  carried: join(named('TESSERA_FIXTURE'), 'carried.ply'),
  cameras: join(named('TESSERA_FIXTURE'), 'transforms.json'),
  fixed: 1000, moving: 1200, seconds: 3, width: 320, height: 240,
};

/** An empty folder of this test file. */
export function scratchFolder() {
  const folder = named('TESSERA_SCRATCH');
  rmSync(folder, {recursive: true, force: true});
  mkdirSync(folder, {recursive: true});
  return folder;
}

/** Runs `tessera …words`; its standard output. Throws with its messages when it fails. */
export function tessera(...words) {
  return execFileSync(named('TESSERA_PROGRAM'), words.map(String),
                      {encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe']});
}

const kTypes = {
  '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript',
  '.json': 'application/json', '.css': 'text/css', '.wasm': 'application/wasm',
  '.png': 'image/png', '.svg': 'image/svg+xml',
};

/** First and last byte of a Range header, or null: not asked for, or not one range. */
function rangeOf(header, size) {
  const match = /^bytes=(\d*)-(\d*)$/.exec(header ?? '');
  if (!match || (match[1] === '' && match[2] === '')) return null;
  if (match[1] === '') return [Math.max(0, size - Number(match[2])), size - 1];
  return [Number(match[1]), match[2] === '' ? size - 1 : Math.min(Number(match[2]), size - 1)];
}

function answer(file, request, response) {
  let size;
  try {
    const stat = statSync(file);
    if (!stat.isFile()) throw new Error('a folder');
    size = stat.size;
  } catch {
    response.writeHead(404).end();
    return;
  }
  const headers = {
    'Content-Type': kTypes[extname(file)] ?? 'application/octet-stream',
    'Accept-Ranges': 'bytes', 'Cache-Control': 'no-store',
  };
  const range = rangeOf(request.headers.range, size);
  if (range && (range[0] >= size || range[0] > range[1])) {
    response.writeHead(416, {'Content-Range': `bytes */${size}`}).end();
    return;
  }
  const [first, last] = range ?? [0, size - 1];
  headers['Content-Length'] = last - first + 1;
  if (range) headers['Content-Range'] = `bytes ${first}-${last}/${size}`;
  response.writeHead(range ? 206 : 200, headers);
  if (request.method === 'HEAD' || size === 0) response.end();
  else createReadStream(file, {start: first, end: last}).pipe(response);
}

/**
 * Serves folders on 127.0.0.1: {'/': folder, '/model/': another, …}, the longest prefix decides.
 * Returns {origin, requests: paths asked for, close}.
 */
export async function serve(roots) {
  const prefixes = Object.keys(roots).sort((a, b) => b.length - a.length);
  const requests = [];
  const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    requests.push(path);
    const prefix = prefixes.find((p) => path.startsWith(p));
    const inside = prefix && normalize(path.slice(prefix.length) || 'index.html');
    if (!prefix || inside.startsWith('..') || inside.startsWith(sep)) response.writeHead(404).end();
    else answer(join(roots[prefix], inside), request, response);
  });
  await new Promise((ready) => server.listen(0, '127.0.0.1', ready));
  const close = () => new Promise((closed) => {
    server.close(closed);
    server.closeAllConnections();
  });
  return {origin: `http://127.0.0.1:${server.address().port}`, requests, close};
}

const kArguments = [
  '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--ignore-gpu-blocklist', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];

/** Chromium with WebGL2 in software. To be closed by the caller. */
export async function launchBrowser() {
  return packages('playwright-core').chromium.launch(
      {executablePath: named('TESSERA_CHROMIUM'), args: kArguments});
}

/**
 * A page of its own, and what goes wrong there: problems.errors (uncaught exceptions, console
 * errors, failed loads) and problems.foreign (requests that leave `origin`, which are blocked).
 */
export async function openPage(browser, {origin, width = 320, height = 240, ...more}) {
  const page = await browser.newPage({viewport: {width, height}, deviceScaleFactor: 1, ...more});
  const problems = {errors: [], foreign: []};
  page.on('pageerror', (error) => problems.errors.push(`exception: ${error.stack ?? error}`));
  page.on('console', (message) => {
    if (message.type() === 'error') problems.errors.push(`console: ${message.text()}`);
  });
  await page.route('**/*', (route) => {
    const url = route.request().url();
    if (url.startsWith(origin) || /^(data|blob):/.test(url)) return route.continue();
    problems.foreign.push(url);
    return route.abort();
  });
  return {page, problems};
}

/** That nothing went wrong and nothing was asked of others. */
export function expectClean(problems) {
  assert.deepEqual(problems, {errors: [], foreign: []});
}

/** PNG → {width, height, data: RGBA bytes}. */
export function readPng(bytesOrPath) {
  return PNG.sync.read(typeof bytesOrPath === 'string' ? readFileSync(bytesOrPath) : bytesOrPath);
}

/** The pixels of the first element that fits the selector, as readPng gives them. */
export async function shot(page, selector = 'canvas') {
  return readPng(await page.locator(selector).first().screenshot({animations: 'disabled'}));
}

/** Peak signal to noise of the colours of two images of one size, dB; Infinity when equal. */
export function psnr(a, b) {
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  let sum = 0;
  for (let i = 0; i < a.data.length; ++i)
    if (i % 4 !== 3) sum += (a.data[i] - b.data[i]) ** 2;
  const mean = sum / (3 * a.width * a.height);
  return mean === 0 ? Infinity : 10 * Math.log10(255 * 255 / mean);
}

/** Pixels whose colours differ by more than `threshold` of 255 in some channel. */
export function differing(a, b, threshold = 0) {
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  let count = 0;
  for (let i = 0; i < a.data.length; i += 4)
    count += [0, 1, 2].some((c) => Math.abs(a.data[i + c] - b.data[i + c]) > threshold);
  return count;
}
