// Exports and serves the page of the fixture's model and opens a browser for the tests of one file.
import {join} from 'node:path';
import {after, before} from 'node:test';
import {fixture, launchBrowser, scratchFolder, serve, tessera} from './harness.mjs';

/** To be called once, outside of tests; `browser`, `origin` and `address` are there in tests. */
export function pageOfModel() {
  const folder = scratchFolder();
  const site = {folder};
  let server;
  before(async () => {
    tessera('export', fixture.model, '--format', 'page', '--cameras', fixture.cameras,
            '-o', join(folder, 'page'));
    site.browser = await launchBrowser();
    server = await serve({'/': folder});
    site.origin = server.origin;
    site.address = `${server.origin}/page/index.html`;
  });
  after(async () => {
    await site.browser?.close();
    await server?.close();
  });
  return site;
}
