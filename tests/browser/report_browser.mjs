// Opens the built page of a report with made-up data in Chromium, from the disk.
import assert from 'node:assert/strict';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before} from 'node:test';

import {launchBrowser, scratchFolder} from './harness.mjs';
import {pageWith} from './report_data.mjs';

const folder = scratchFolder();
const template = join(process.env.TESSERA_PLAYER_WORK, '..', 'report.html');
export const kWide = {width: 1280, height: 720};
export const kNarrow = {width: 390, height: 844};
let browser;

before(async () => {
  browser = await launchBrowser();
});
after(() => browser?.close());

/** Runs `check` on the page of the data; nothing may go wrong there or be asked for elsewhere. */
export async function onPage(data, viewport, check, more = {}) {
  const file = join(folder, 'index.html');
  writeFileSync(file, pageWith(template, data));
  const page = await browser.newPage({viewport, ...more});
  const wrong = [];
  page.on('pageerror', (error) => wrong.push(String(error.stack)));
  page.on('console', (message) => message.type() !== 'log' && wrong.push(message.text()));
  page.on('request', (request) => {
    if (!/^(file|data|blob):/.test(request.url())) wrong.push(request.url());
  });
  await page.goto(`file://${file}`);
  await check(page);
  assert.deepEqual(wrong, []);
  await page.close();
}
