// Fetches bytes from an address, with progress and with error messages that name the remedy.
import { isAbort, PlayerError } from "./player_error";

export interface FetchOptions {
  signal?: AbortSignal;
  /** First byte and how many, where only a part is wanted. */
  range?: { offset: number; bytes: number };
  /** Called with the bytes that have newly arrived. */
  onBytes?: (count: number) => void;
}

/** The last part of an address, for messages. */
export function nameOf(url: string): string {
  const path = url.split(/[?#]/)[0];
  return decodeURIComponent(path.slice(path.lastIndexOf("/") + 1)) || url;
}

function unreachable(url: string): PlayerError {
  if (url.startsWith("file:"))
    return new PlayerError(
      `${nameOf(url)}: browsers do not let a page read files from a disk; serve its folder ` +
        `(tessera view) or export with --format html, which is one file`,
      "network",
    );
  return new PlayerError(
    `${nameOf(url)}: no answer from the server; check the connection and that it is still running`,
    "network",
  );
}

function refused(url: string, status: number): PlayerError {
  const remedy =
    status === 404 ? "it is missing: copy the whole export folder" : "check the server's rights";
  return new PlayerError(
    `${nameOf(url)}: the server answers ${status}; ${remedy}`,
    status >= 500 ? "network" : "data",
  );
}

async function bodyOf(response: Response, options: FetchOptions): Promise<Uint8Array> {
  if (response.body === null || options.onBytes === undefined)
    return new Uint8Array(await response.arrayBuffer());
  const parts: Uint8Array[] = [];
  let length = 0;
  const reader = response.body.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    length += value.length;
    options.onBytes(value.length);
  }
  const bytes = new Uint8Array(length);
  let offset = 0;
  for (const part of parts) {
    bytes.set(part, offset);
    offset += part.length;
  }
  return bytes;
}

/**
 * The bytes at `url`; of a range where one is given and the server knows ranges (`whole`: it does
 * not, these are all bytes of the file). Throws PlayerError, or AbortError when given up.
 */
export async function fetchBytes(
  url: string,
  options: FetchOptions = {},
): Promise<{ bytes: Uint8Array; whole: boolean }> {
  const { range } = options;
  const headers: HeadersInit = range
    ? { Range: `bytes=${range.offset}-${range.offset + range.bytes - 1}` }
    : {};
  try {
    const response = await fetch(url, { headers, signal: options.signal });
    if (!response.ok) throw refused(url, response.status);
    return { bytes: await bodyOf(response, options), whole: response.status !== 206 };
  } catch (error) {
    if (isAbort(error) || error instanceof PlayerError) throw error;
    throw unreachable(url);
  }
}
