// A made-up report of a batch in the form that tools/web/report/data.ts describes.
import {runData} from './report_data.mjs';

function spread(median, range = 0.3) {
  return {median, least: median - range, most: median + range, count: 3};
}

const kVariants = [
  {name: 'fast', preset: 'fast', options: {}},
  {name: 'balanced', preset: 'balanced', options: {iterations: 3000}, label: 'balanced, 3000'},
  {name: 'best', preset: 'best', options: {}, published: [
    {source: 'a paper, RTX 4090', scene: 'hall', figures: {psnr: 30.5, seconds: 300}},
    {source: 'a paper, mean of others', scene: '', figures: {psnr: 27.5, seconds: 400}}]},
];

function point(variant, v, s) {
  const seconds = [4, 13, 60][v];
  return {label: variant.name, iterations: 1000 * 3 ** v, n: 3, devices: ['H100'], metrics: {
    psnr: spread([27, 30, 31][v] + s), ssim: spread(0.9 + 0.02 * v, 0.001),
    seconds: spread(seconds, 0.2), command_seconds: spread(seconds + 9, 0.5),
    num_gaussians: spread(1e5 * (v + 1), 1000), shipped_bytes: spread(4e6 * (v + 1), 1e4),
    bytes: spread(2e7 * (v + 1), 1e4)}};
}

/** Three variants and two seeds of each of `count` scenes, one of them without held-out views. */
export function batchData({count = 2, failures = []} = {}) {
  const names = ['hall', 'garden <b>', ...Array.from({length: count}, (_, i) => `scene ${i}`)]
      .slice(0, count);
  const runs = names.flatMap((scene, s) => kVariants.flatMap((variant, v) => [1, 2].map((seed) => {
    const run = runData({title: `${variant.name}, seed ${seed}`, better: v + s});
    return {...run, id: `${scene}/${variant.name}/seed-${seed}`, scene, variant: variant.name, seed,
            error: null, views: seed === 1 ? run.views : [],
            warnings: [{stage: 'ingest', text: `${scene}: the clocks differ`}]};
  })));
  return {
    schema: 1, kind: 'batch', title: 'Übernacht <i>', version: '1.4.0',
    made: '2026-11-24T09:45:00Z', runs,
    batch: {
      folder: '/data/out', summary: `${runs.length} of ${runs.length} runs done, 0 failed, 0 not run`,
      counts: {runs: runs.length, done: runs.length, failed: 0, missing: 0, scenes: count,
               whole_scenes: count},
      versions: ['1.4.0'], devices: ['H100'], variants: kVariants,
      captures: names.map((name) => ({name, path: `/data/${name}`, ingest: ['--scale', '0.5']})),
      scenes: names.map((scene, s) => ({scene, split: s === 1 ? 'train' : 'test',
                                        points: kVariants.map((variant, v) => point(variant, v, s))})),
      earlier: [], failures, notes: [],
    },
  };
}
