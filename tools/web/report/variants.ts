// Tables of a batch: scenes by variants, and the variants of one scene with all that is measured.
import type { Batch, Metric, Point, SceneScores } from "./data";
import { make, type Child } from "./elements";
import { table, type Column } from "./tables";
import { decibels, fixed, shortNumber, sizeWords, timeWords, UNKNOWN, wholeNumber } from "./words";

type Best = "high" | "low" | "";

interface Measure {
  name: string;
  metric: Metric;
  best: Best;
  words: (value: number) => string;
  range?: (value: number) => string; // of the seeds, shown where it matters
}

const two = (value: number) => fixed(value, 2);
const MEASURES: Measure[] = [
  { name: "PSNR", metric: "psnr", best: "high", words: decibels, range: two },
  { name: "moving pixels", metric: "psnr_dynamic", best: "high", words: decibels, range: two },
  { name: "SSIM", metric: "ssim", best: "high", words: (value) => fixed(value, 4) },
  { name: "LPIPS", metric: "lpips", best: "low", words: (value) => fixed(value, 4) },
  { name: "whole command", metric: "command_seconds", best: "low", words: timeWords,
    range: timeWords },
  { name: "training", metric: "seconds", best: "low", words: timeWords, range: timeWords },
  { name: "Gaussians", metric: "num_gaussians", best: "", words: shortNumber },
  { name: "4D file", metric: "shipped_bytes", best: "low", words: sizeWords },
  { name: "model", metric: "bytes", best: "low", words: sizeWords },
  { name: "peak memory", metric: "peak_device_bytes", best: "low", words: sizeWords },
];

export function medianOf(point: Point | undefined, metric: Metric): number | null {
  return point?.metrics[metric]?.median ?? null;
}

/** Names of the variants that have points, in the order of the request. */
export function variantsOf(batch: Batch): string[] {
  return [...new Set(batch.scenes.flatMap(({ points }) => points.map(({ label }) => label)))];
}

/** The name that people read: that of a table's row, else the variant's own. */
export function nameOf(batch: Batch, variant: string): string {
  return batch.variants.find(({ name }) => name === variant)?.label || variant;
}

/** Whether it is the best of at least two that differ. */
export function isBest(value: number | null, others: (number | null)[], best: Best): boolean {
  if (value === null || best === "") return false;
  const known = others.filter((other) => other !== null);
  const most = best === "high" ? Math.max(...known) : Math.min(...known);
  return value === most && known.some((other) => other !== value);
}

function emphasised(text: string, strong: boolean): Child {
  return strong ? make("strong", { title: "best" }, text) : text;
}

/** A row of the table of scenes: a scene, or the means over those that all variants have. */
interface SceneRow {
  name: string;
  note: string;
  value: (variant: string, metric: Metric) => number | null;
}

function meanRow(batch: Batch): SceneRow | null {
  const variants = variantsOf(batch);
  const psnr = ({ points }: SceneScores, variant: string) =>
    medianOf(points.find(({ label }) => label === variant), "psnr");
  const whole = batch.scenes.filter((scene) =>
    variants.every((variant) => psnr(scene, variant) !== null));
  if (whole.length < 2) return null;
  const value = (variant: string, metric: Metric) => {
    const values = whole.map(({ points }) =>
      medianOf(points.find(({ label }) => label === variant), metric));
    const known = values.filter((one) => one !== null);
    if (known.length < values.length) return null;
    return known.reduce((sum, one) => sum + one, 0) / known.length;
  };
  return { name: `mean of ${whole.length} scenes`, note: "", value };
}

/** PSNR of every scene, with time and size below it. */
export function scenesTable(batch: Batch): HTMLElement {
  const variants = variantsOf(batch);
  const rows: SceneRow[] = batch.scenes.map(({ scene, split, points }) => ({
    name: scene,
    note: split === "train" ? "training views" : "",
    value: (variant, metric) => medianOf(points.find(({ label }) => label === variant), metric),
  }));
  const mean = meanRow(batch);
  if (mean !== null) rows.push(mean);
  const cell = (row: SceneRow, variant: string): Child => {
    const psnr = row.value(variant, "psnr");
    if (psnr === null) return UNKNOWN;
    const best = isBest(psnr, variants.map((other) => row.value(other, "psnr")), "high");
    const seconds = row.value(variant, "command_seconds") ?? row.value(variant, "seconds");
    const bytes = row.value(variant, "shipped_bytes") ?? row.value(variant, "bytes");
    return make("span", {}, emphasised(decibels(psnr), best), make("br"),
      make("span", { class: "soft" }, `${timeWords(seconds)}, ${sizeWords(bytes)}`));
  };
  const columns: Column<SceneRow>[] = [
    { name: "scene", cell: ({ name, note }) => make("span", {}, name,
      note === "" ? null : make("span", { class: "soft" }, ` ${note}`)) },
    ...variants.map((variant): Column<SceneRow> => ({
      name: nameOf(batch, variant), number: true, cell: (row) => cell(row, variant),
    })),
  ];
  return make("div", { class: "card" }, table("PSNR of all scenes", columns, rows),
    make("p", { class: "soft" }, "Medians over the seeds, on the held-out views; the best of a " +
      "scene is bold. Below: seconds of the whole command (of the training where they are not " +
      "known) and size of the 4D file (of the model where there is none)."));
}

function spreadCell(point: Point, points: Point[], measure: Measure): Child {
  const spread = point.metrics[measure.metric];
  if (spread === undefined) return UNKNOWN;
  const { median, least, most } = spread;
  const medians = points.map((other) => medianOf(other, measure.metric));
  const text = emphasised(measure.words(median), isBest(median, medians, measure.best));
  if (least === most || measure.range === undefined) return text;
  return make("span", {}, text, make("br"),
    make("span", { class: "soft" }, `${measure.range(least)}–${measure.range(most)}`));
}

/** Figures of others that the rows of a table name, of this scene or of means over others. */
function publishedOf(batch: Batch, { scene }: SceneScores): HTMLElement[] {
  return batch.variants.flatMap((variant) => (variant.published ?? []).flatMap((one) => {
    const meant = one.scene === "" || scene === one.scene || scene.endsWith(`_${one.scene}`);
    if (!meant) return [];
    const words = MEASURES.filter(({ metric }) => one.figures[metric] !== undefined)
      .map((measure) => `${measure.name} ${measure.words(one.figures[measure.metric]!)}`);
    const name = variant.label || (variant.name ?? "");
    return make("li", {}, `${name}: ${words.join(", ")} (${one.source})`);
  }));
}

/** All that is measured of a scene. */
export function pointsTable(scene: SceneScores, batch: Batch): HTMLElement {
  const { points } = scene;
  const measured = MEASURES.filter(({ metric }) => points.some(({ metrics }) => metrics[metric]));
  const columns: Column<Point>[] = [
    { name: "preset", cell: ({ label }) => nameOf(batch, label),
      order: ({ label }) => nameOf(batch, label) },
    { name: "seeds", number: true, cell: ({ n }) => wholeNumber(n) },
    { name: "steps", number: true, cell: (point) => wholeNumber(point.iterations),
      order: (point) => point.iterations },
    ...measured.map((measure): Column<Point> => ({
      name: measure.name, number: true, order: (point) => medianOf(point, measure.metric),
      cell: (point) => spreadCell(point, points, measure),
    })),
  ];
  const published = publishedOf(batch, scene);
  return make("div", { class: "card" }, table(`presets on ${scene.scene}`, columns, points),
    published.length === 0 ? null : make("p", { class: "soft" }, "Published, on other machines:"),
    published.length === 0 ? null : make("ul", { class: "soft" }, ...published));
}
