// PSNR of the variants of a scene against seconds, bytes and Gaussians, beside figures of others.
import { COLOURS } from "./charts";
import type { Batch, Metric, Point, SceneScores } from "./data";
import { Scatter, type Axis, type Dot, type Place } from "./scatter";
import { nameOf, variantsOf } from "./variants";
import { decibels, shortNumber, sizeWords, timeWords } from "./words";

const AXES: (Axis & { metric: Metric; scale: number; words: (value: number) => string })[] = [
  { name: "whole command", unit: "s", log: true, metric: "command_seconds", scale: 1,
    words: timeWords },
  { name: "training", unit: "s", log: true, metric: "seconds", scale: 1, words: timeWords },
  { name: "4D file", unit: "MB", log: true, metric: "shipped_bytes", scale: 1e-6,
    words: sizeWords },
  { name: "model", unit: "MB", log: true, metric: "bytes", scale: 1e-6, words: sizeWords },
  { name: "Gaussians", unit: "number", log: true, metric: "num_gaussians", scale: 1,
    words: shortNumber },
];

function place(point: Point, metric: Metric, scale: number): Place | null {
  const spread = point.metrics[metric];
  if (spread === undefined || !(spread.least > 0)) return null;
  return { at: scale * spread.median, least: scale * spread.least, most: scale * spread.most };
}

function dotOf(batch: Batch, point: Point, colour: string): Dot | null {
  const y = point.metrics.psnr;
  if (y === undefined) return null;
  const known = AXES.filter(({ metric }) => point.metrics[metric] !== undefined);
  const costs = known.map(({ name, metric, words }) =>
    `${name} ${words(point.metrics[metric]!.median)}`);
  const name = nameOf(batch, point.label);
  return {
    name, colour, hollow: false,
    x: AXES.map(({ metric, scale }) => place(point, metric, scale)),
    y: { at: y.median, least: y.least, most: y.most },
    words: `${name}: ${decibels(y.median)}, ${costs.join(", ")}`,
  };
}

/** Those that have a score and a cost. */
function publishedDots(batch: Batch, { scene }: SceneScores, colours: Map<string, string>): Dot[] {
  return batch.variants.flatMap((variant) => (variant.published ?? []).flatMap((one) => {
    const { psnr } = one.figures;
    if (psnr === undefined || (one.scene !== scene && !scene.endsWith(`_${one.scene}`))) return [];
    if (one.scene === "") return []; // a mean over other scenes
    const exact = (value: number | undefined, scale: number): Place | null =>
      value === undefined ? null : { at: scale * value, least: scale * value, most: scale * value };
    return {
      name: "published", colour: colours.get(variant.name ?? "") ?? "#8A8F99", hollow: true,
      x: AXES.map(({ metric, scale }) => exact(one.figures[metric], scale)),
      y: exact(psnr, 1)!, words: `${decibels(psnr)}: ${one.source}, another machine`,
    };
  }));
}

/** null where no point has both a score and a cost. */
export function qualityChart(scene: SceneScores, batch: Batch): HTMLElement | null {
  const names = variantsOf(batch);
  const colours = new Map(names.map((name, i) => [name, COLOURS[i % COLOURS.length]]));
  const measured = scene.points.map((point) => dotOf(batch, point, colours.get(point.label)!));
  const dots = [...measured.filter((dot) => dot !== null), ...publishedDots(batch, scene, colours)];
  const used = AXES.map((_, i) => i).filter((i) => dots.some((dot) => dot.x[i] !== null));
  if (used.length === 0) return null;
  const chosen = dots.map((dot) => ({ ...dot, x: used.map((i) => dot.x[i]) }));
  return new Scatter(`Quality on ${scene.scene}`, "PSNR [dB]", used.map((i) => AXES[i]),
    chosen).element;
}
