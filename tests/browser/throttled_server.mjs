// A file server on 127.0.0.1 that knows ranges and counts what it sends. Scenes (.t4d, .bin) come as
// over a slow line: an answer begins late, and all of them share a number of bytes a second.
import {readFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {setTimeout as wait} from 'node:timers/promises';

const kPart = 4096;  // bytes that are sent at a time

/** Waits until the line is free for so many bytes more. */
function lineOf(bytesPerSecond) {
  let free = 0;  // ms; when everything before has been sent
  return async (count) => {
    const now = performance.now();
    free = Math.max(now, free) + (1000 * count) / bytesPerSecond;
    await wait(free - now);
  };
}

/**
 * `files`: {'/a.t4d': path}. Returns {origin, sent: [{path, first, bytes}] of scenes, with the bytes
 * that have gone out; close}.
 */
export async function serveSlowly(files, {bytesPerSecond, latency}) {
  const contents = new Map(Object.entries(files).map(([path, file]) => [path, readFileSync(file)]));
  const line = lineOf(bytesPerSecond);
  const sent = [];
  const server = createServer(async (request, response) => {
    const path = new URL(request.url, 'http://localhost').pathname;
    const bytes = contents.get(path);
    if (bytes === undefined) return response.writeHead(404).end();
    const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? '');
    const first = range ? Number(range[1]) : 0;
    const end = range ? Math.min(Number(range[2]) + 1, bytes.length) : bytes.length;
    const slow = /\.(t4d|bin)$/.test(path);
    const entry = {path, first, bytes: 0};
    if (slow) {
      sent.push(entry);
      await wait(latency);
    }
    response.writeHead(range ? 206 : 200, {
      'Content-Type': path.endsWith('.html') ? 'text/html' : 'application/octet-stream',
      'Content-Length': end - first, 'Cache-Control': 'no-store', 'Accept-Ranges': 'bytes',
      ...(range && {'Content-Range': `bytes ${first}-${end - 1}/${bytes.length}`}),
    });
    if (!slow) return response.end(bytes.subarray(first, end));
    for (let next = first; next < end && !response.destroyed; next += kPart) {
      const part = bytes.subarray(next, Math.min(end, next + kPart));
      await line(part.length);
      entry.bytes += part.length;
      response.write(part);
    }
    return response.end();
  });
  await new Promise((ready) => server.listen(0, '127.0.0.1', ready));
  const close = () => new Promise((closed) => {
    server.close(closed);
    server.closeAllConnections();
  });
  return {origin: `http://127.0.0.1:${server.address().port}`, sent, close};
}
