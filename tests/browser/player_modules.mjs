// Compiles modules of the web pages for Node, so that parts which need no browser are tested
// without one.
import {mkdtempSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

/** Where the build put the sources and packages of the pages. */
const work = process.env.TESSERA_PLAYER_WORK;
if (!work) throw new Error('TESSERA_PLAYER_WORK is not set; run through ctest -L browser');

/** What player/NAME.ts export, several as one so that they share their classes. */
export const playerModules = (...names) => modules('player', names);
/** The same of report/NAME.ts. */
export const reportModules = (...names) => modules('report', names);

async function modules(page, names) {
  const esbuild = createRequire(join(work, 'package.json'))('esbuild');
  const outfile = join(mkdtempSync(join(tmpdir(), 'player_')), 'modules.mjs');
  const contents = names.map((name) => `export * from './${name}';`).join('\n');
  await esbuild.build({stdin: {contents, resolveDir: join(work, page), loader: 'ts'}, bundle: true,
                       outfile, format: 'esm', platform: 'neutral', logLevel: 'error'});
  return import(pathToFileURL(outfile).href);
}
