// Fetches the packages of a package-lock.json for this machine, as `npm ci --ignore-scripts` does, by
// curl and tar, unless they are there already: npm itself is 341 packages on a bare Debian.
// Usage: node fetch_packages.mjs LOCK_FILE FOLDER   writes FOLDER/node_modules
import {execFileSync} from 'node:child_process';
import {createHash} from 'node:crypto';
import {copyFileSync, existsSync, mkdirSync, readFileSync, rmSync} from 'node:fs';
import {basename, join} from 'node:path';

const [lock, folder] = process.argv.slice(2);
const registry = (process.env.npm_config_registry ?? 'https://registry.npmjs.org').replace(/\/$/, '');

const fetched = join(folder, 'fetched-lock.json');
if (existsSync(fetched) && readFileSync(fetched).equals(readFileSync(lock))) process.exit(0);
rmSync(fetched, {force: true});

/** Whether a list of os or cpu of a package has that of this machine; "!x": all but x. */
function fits(list, mine) {
  if (!list) return true;
  return list.some((item) => item.startsWith('!')) ? !list.includes(`!${mine}`) : list.includes(mine);
}

/** That its bytes are those of the lock file. */
function check(file, name, integrity) {
  const [algorithm, expected] = [integrity.slice(0, integrity.indexOf('-')),
                                 integrity.slice(integrity.indexOf('-') + 1)];
  if (createHash(algorithm).update(readFileSync(file)).digest('base64') !== expected)
    throw new Error(`${name}: not the file of ${lock}`);
}

const packages = Object.entries(JSON.parse(readFileSync(lock)).packages)
    .filter(([place, p]) => place && fits(p.os, process.platform) && fits(p.cpu, process.arch) &&
                            fits(p.libc, 'glibc'))
    .map(([place, p]) => {
      const name = p.name ?? place.slice(place.lastIndexOf('node_modules/') + 13);
      const url = p.resolved ?? `${registry}/${name}/-/${basename(name)}-${p.version}.tgz`;
      return {place, name, url, integrity: p.integrity};
    });

const archives = join(folder, 'archives');
rmSync(join(folder, 'node_modules'), {recursive: true, force: true});
mkdirSync(archives, {recursive: true});
packages.forEach((p, i) => p.file = join(archives, `${i}.tgz`));
try {
  execFileSync('curl', ['-fsSL', '--no-progress-meter', '--retry', '3', '--parallel', '--parallel-max', '8',
                        ...packages.flatMap((p) => ['-o', p.file, p.url])],
               {stdio: ['ignore', 'inherit', 'inherit']});
  for (const {place, name, file, integrity} of packages) {
    check(file, name, integrity);
    mkdirSync(join(folder, place), {recursive: true});
    execFileSync('tar', ['-xzf', file, '-C', join(folder, place), '--strip-components=1',
                         '--no-same-owner']);
  }
  copyFileSync(lock, fetched);
} catch (error) {
  console.error(error.message.split('\n')[0]);
  process.exitCode = 1;
} finally {
  rmSync(archives, {recursive: true, force: true});
}
