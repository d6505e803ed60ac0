// Reads the manifest of a folder of frames (tessera export --format ply|compressed|spz|splat).
import {
  readBounds,
  readCameras,
  type Bounds,
  type Camera,
  type SplatRules,
  type Triple,
} from "./manifest";
import { nameOf } from "./fetching";
import { PlayerError } from "./player_error";

export interface SequenceFrame {
  url: string;
  name: string;
  t: number; // 0: the first frame, 1: the last one
  gaussians: number;
  bytes: number | null;
}

export interface Sequence {
  name: string;
  fileType: "ply" | "spz" | "splat";
  frames: SequenceFrame[]; // by time
  time: { origin: number; duration: number; fps: number | null }; // seconds
  background: Triple; // sRGB, 0 to 255
  bounds: Bounds | null;
  up: Triple;
  cameras: Camera[];
  splat: SplatRules;
}

/** How 3DGS files are drawn; they do not say it themselves. */
const RULES_3DGS: SplatRules = {
  dilation: 0.3,
  compensated: false,
  cutoffSigma: 3.329,
  cutoffAlpha: 1 / 255,
  near: null,
};

const FILE_TYPES: Record<string, Sequence["fileType"]> = {
  ply: "ply",
  compressed: "ply",
  spz: "spz",
  splat: "splat",
};

function formatName(json: Record<string, unknown>): string | null {
  const match = /^3dgs-(.+)-sequence$/.exec(String(json.format));
  return match ? match[1] : null;
}

export function isSequence(json: Record<string, unknown>): boolean {
  return formatName(json) !== null;
}

function tripleOr(value: unknown, fallback: Triple): Triple {
  return Array.isArray(value) && value.length === 3 && value.every(Number.isFinite)
    ? (value as Triple)
    : fallback;
}

function readFrame(item: unknown, i: number, manifest: string): SequenceFrame {
  const frame = (item ?? {}) as Record<string, unknown>;
  const file = frame.file;
  const t = frame.time;
  if (typeof file !== "string" || /^[/\\]|[:\\]|(^|\/)\.\.(\/|$)/.test(file))
    throw new PlayerError(
      `${nameOf(manifest)}: frames[${i}].file should be a file below the manifest; export again`,
    );
  if (typeof t !== "number" || !Number.isFinite(t))
    throw new PlayerError(
      `${nameOf(manifest)}: frames[${i}].time should be a number; export the frames again`,
    );
  return {
    url: new URL(file, manifest).href,
    name: file,
    t,
    gaussians: Number(frame.gaussians) || 0,
    bytes: typeof frame.bytes === "number" ? frame.bytes : null,
  };
}

function readRules(value: unknown): SplatRules {
  const rules = (value ?? {}) as Record<string, unknown>;
  return {
    dilation: Number(rules.dilation ?? RULES_3DGS.dilation),
    compensated: rules.compensated === true,
    cutoffSigma: Number(rules.cutoff_sigma ?? RULES_3DGS.cutoffSigma),
    cutoffAlpha: Number(rules.cutoff_alpha ?? RULES_3DGS.cutoffAlpha),
    near: Number(rules.near) || null,
  };
}

/** Throws PlayerError where a frame cannot be found by it. */
export function readSequence(json: Record<string, unknown>, url: string): Sequence {
  const name = nameOf(url);
  const format = formatName(json) ?? "";
  const fileType = FILE_TYPES[format];
  if (fileType === undefined)
    throw new PlayerError(
      `${name}: frames of format "${format}" do not play here; ` +
        `export ply, compressed, spz or splat`,
    );
  if (!Array.isArray(json.frames) || json.frames.length === 0)
    throw new PlayerError(`${name}: no frames; export them again`);
  const frames = json.frames.map((item, i) => readFrame(item, i, url));
  frames.sort((a, b) => a.t - b.t);
  const [first, last] = [frames[0].t, frames[frames.length - 1].t]; // of the capture's clip
  const span = last - first;
  for (const frame of frames) frame.t = span > 0 ? (frame.t - first) / span : 0;
  const axis = (json.time_axis ?? {}) as Record<string, unknown>;
  const duration = Math.max(0, Number(axis.duration) || 0);
  return {
    name,
    fileType,
    frames,
    time: {
      origin: (Number(axis.origin) || 0) + first * duration,
      duration: span * duration,
      fps: typeof json.fps === "number" && json.fps > 0 ? json.fps : null,
    },
    background: tripleOr(json.background, [0, 0, 0]),
    bounds: readBounds(json.bounds, name),
    up: tripleOr(json.up, [0, -1, 0]),
    cameras: readCameras(json, name),
    splat: readRules(json.splat),
  };
}
