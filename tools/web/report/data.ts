// The data that the program writes into the page, and its check. Values that are unknown are null.
export interface Report {
  schema: 1;
  kind: "run" | "comparison" | "batch";
  title: string;
  version: string;
  made: string; // ISO, UTC
  runs: Run[];
  batch?: Batch; // of a batch
}

export interface Run {
  id: string;
  title: string;
  preset: string;
  seed: number | null;
  version: string;
  command: string;
  started: string;
  host: string;
  cpu: string;
  device: string;
  state: "done" | "unfinished" | "missing" | "failed"; // the last two of a batch
  scene?: string; // of a batch
  variant?: string; // a preset with its options, of a batch
  error?: string | null;
  split: "test" | "val" | "train" | "";
  steps: number;
  options: Record<string, unknown>; // of the training, all
  ingest_options: Record<string, unknown>; // as they were asked for; of a training alone none
  initial_points: string; // in words
  scores: Scores;
  verdict: string; // what such a PSNR looks like; "" of training views
  worst: { frame_number: number; psnr: number } | null; // the timestep of lowest PSNR
  objects: { name: string; psnr: number }[];
  size: Sizes;
  stages: { name: string; seconds: number }[];
  seconds: { command: number | null; training: number | null };
  curves: Record<CurveName, Curve>;
  views: View[];
  cameras: Camera[];
  decisions: Decision[];
  warnings: { stage: string; text: string }[];
  files: { name: string; path: string; bytes: number | null }[]; // paths from the page's folder
  image_note: string | null; // why there are no images
  windows?: Window[]; // of a clip that was trained window by window
  borders?: Borders | null;
}

/** What the training changed by itself; numbers of Gaussians before and after where it has them. */
export interface Decision {
  step: number;
  text: string;
  static?: [number, number];
  dynamic?: [number, number];
}

/** One window; scores are means over the views that are drawn of it. */
export interface Window {
  folder: string;
  begin: number; // s of the clip
  end: number;
  state: "done" | "unfinished";
  psnr: number | null;
  psnr_dynamic: number | null;
  psnr_static: number | null;
  dynamic: number; // Gaussians
  steps: number;
  seconds: number | null; // of training
}

/** Temporal error between neighbouring timesteps, 1/255. */
type Borders = Record<"inside" | "border" | "inside_moving" | "border_moving", number | null>;

export type Scores = Record<
  "psnr" | "psnr_dynamic" | "psnr_static" | "psnr_fit" | "ssim" | "lpips",
  number | null
>;

interface Sizes {
  static: number;
  dynamic: number;
  model_bytes: number | null;
  shipped_bytes?: number | null; // of the Tessera 4D file
  player_bytes: number | null;
  peak_bytes: number | null;
}

export type CurveName =
  | "psnr_test"
  | "psnr_validation"
  | "loss"
  | "static"
  | "dynamic"
  | "memory"; // bytes

export interface Curve {
  step: number[];
  seconds: (number | null)[]; // of training, at that step
  value: number[];
}

export interface View {
  name: string;
  camera: string;
  time: number;
  psnr: number;
  psnr_dynamic: number | null;
  psnr_static: number | null;
  role: "worst" | "median" | "best" | null;
  strip: boolean; // whether it belongs to the strip of its camera
  width: number;
  height: number;
  truth: string | null; // addresses of images, null where not rendered
  result: string | null;
  error: string | null;
}

export interface Camera {
  name: string;
  width: number;
  height: number;
  frames_per_second: number | null;
  frames_in_file: number;
  frames_kept: number;
  pose_source: string;
  pose_error_px: number | null;
  clock_offset_s: number;
  clock_offset_frames: number;
  clock_error_frames: number; // 0: stated, or not known
  clock_source: string;
  readout_s: number; // as it is stated; 0: none
  clock_learnt_s: number | null; // what the training added
  readout_learnt_s: number | null;
  gain: number | null;
  roll_degrees: number | null;
  role: "test" | "train";
  leave_out: boolean;
  notes: string[]; // what is odd about it
}

/** What the runs of a batch have in common. */
export interface Batch {
  folder: string;
  summary: string;
  counts: Record<"runs" | "done" | "failed" | "missing" | "scenes" | "whole_scenes", number>;
  versions: string[];
  devices: string[];
  variants: Variant[];
  captures: { name?: string; path?: string; ingest?: string[] }[];
  scenes: SceneScores[];
  earlier: Run[]; // finished, but not of this request
  failures: { line: string; log: string }[];
  notes: string[];
}

export interface Variant {
  name?: string;
  label?: string; // of a row of a table
  preset?: string;
  options?: Record<string, unknown>;
  published?: { source: string; scene: string; figures: Partial<Record<Metric, number>> }[];
}

export interface SceneScores {
  scene: string;
  split: Run["split"];
  points: Point[];
}

/** The seeds of one scene and variant. */
export interface Point {
  label: string; // the variant's name
  iterations: number;
  n: number; // that have scores
  devices: string[];
  metrics: Partial<Record<Metric, Spread>>;
}

export type Metric =
  | "psnr" | "psnr_dynamic" | "ssim" | "lpips" | "seconds" | "command_seconds"
  | "num_gaussians" | "bytes" | "shipped_bytes" | "peak_device_bytes";

export interface Spread {
  median: number;
  least: number;
  most: number;
  count: number;
}

/** The report that the text holds, "live" where the training is to be followed, or one line that says
 * why there is none. */
export function readReport(text: string): Report | "live" | string {
  let data: { schema?: unknown; runs?: unknown } | null;
  try {
    data = JSON.parse(text);
  } catch {
    return "The data of this report cannot be read: it is not JSON.";
  }
  if ((data as unknown) === "live") return "live";
  if (data === null || typeof data !== "object") return "This page has no report.";
  if (typeof data.schema === "number" && data.schema > 1)
    return (
      `This report has schema ${data.schema}, and this page reads schema 1: ` +
      "make the page with a newer Tessera."
    );
  if (data.schema !== 1) return "The data of this report has no schema that this page reads.";
  const { kind } = data as Report;
  if (!Array.isArray(data.runs) || (data.runs.length === 0 && kind !== "batch"))
    return "This report has no runs.";
  return data as Report;
}
