// Opens the scene that the page's configuration or its address names: a Tessera 4D file or a
// sequence of frames.
import { bytesOfBase64, bytesSource, folderSource, singleFileSource } from "./container";
import type { BlockSource } from "./container";
import { fetchBytes, nameOf } from "./fetching";
import { FORMAT, parseJson } from "./manifest";
import { PlayerError } from "./player_error";
import { isSequence, readSequence, type Sequence } from "./sequence_manifest";

/** The JSON in the page's element #tessera-config. */
export interface PageConfig {
  scene?: string; // a manifest.json or a .t4d, relative to the page
  data?: string; // a .t4d
  encoding?: "base64";
  truth?: unknown; // as readTruth() of comparison.ts takes it
}

export type OpenedSource =
  | { kind: "4d"; blocks: BlockSource }
  | { kind: "sequence"; sequence: Sequence };

export function readConfig(text: string): PageConfig {
  try {
    return JSON.parse(text) as PageConfig;
  } catch {
    throw new PlayerError("this page's configuration is no JSON; export the page again");
  }
}

/** `override`: the address's scene=, before what the page says. Throws PlayerError. */
export async function openSource(
  config: PageConfig,
  override: string | null,
  page: string,
): Promise<OpenedSource> {
  if (override === null && config.data !== undefined) {
    if (config.encoding !== "base64")
      throw new PlayerError(
        `the scene within this page is encoded as ${config.encoding}, not base64; export it again`,
      );
    const bytes = bytesOfBase64(config.data);
    return { kind: "4d", blocks: bytesSource(bytes, "the scene within this page", null) };
  }
  const url = new URL(override ?? config.scene ?? "manifest.json", page).href;
  if (/\.t4d$/i.test(new URL(url).pathname))
    return { kind: "4d", blocks: await singleFileSource(url, {}) };
  const text = new TextDecoder().decode((await fetchBytes(url)).bytes);
  const json = parseJson(text, nameOf(url));
  if (json.format === FORMAT) return { kind: "4d", blocks: folderSource(json, url) };
  if (isSequence(json)) return { kind: "sequence", sequence: readSequence(json, url) };
  throw new PlayerError(
    `${nameOf(url)}: format ${JSON.stringify(json.format)} is not known here; ` +
      `point scene at the manifest of a tessera export`,
  );
}
