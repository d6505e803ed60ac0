// A made-up report in the form that tools/web/report/data.ts describes, and its page.
import {readFileSync} from 'node:fs';

const kCameras = ['cam00', 'cam01'];
const kFramesPerCamera = 6;

/** An SVG of one colour with a disc, as an address. */
export function imageAddress(colour, place = 0.5, width = 320, height = 180) {
  const svg = `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}">` +
      `<rect width="100%" height="100%" fill="${colour}"/>` +
      `<circle cx="${place * width}" cy="${height / 2}" r="${height / 5}" fill="#fff8"/></svg>`;
  return `data:image/svg+xml;base64,${Buffer.from(svg).toString('base64')}`;
}

/** `value` at each step. */
function curve(steps, value, secondsPerStep = 0.02) {
  const seconds = steps.map((step) => step * secondsPerStep);
  return {step: steps, seconds, value: steps.map(value)};
}

function steps(count, interval) {
  return Array.from({length: count}, (_, i) => (i + 1) * interval);
}

function views(better) {
  return kCameras.flatMap((camera, c) => Array.from({length: kFramesPerCamera}, (_, i) => {
    const hue = 60 * i + 25 * c, place = (i + 1) / (kFramesPerCamera + 1);
    return {
      name: `${camera}/frame_${String(i).padStart(4, '0')}`, camera,
      time: i / (kFramesPerCamera - 1), psnr: 24 + 1.37 * ((i * 5 + c * 3) % 12) + better,
      psnr_dynamic: i === 2 ? null : 21.5 + i + better, psnr_static: 33.25 - 0.4 * i + better,
      role: c === 0 ? {0: 'worst', 2: 'median', 4: 'best'}[i] ?? null : null, strip: true,
      width: 320, height: 180, truth: imageAddress(`hsl(${hue} 60% 45%)`, place),
      result: imageAddress(`hsl(${hue} 40% ${55 + 5 * better}%)`, place + 0.02),
      error: imageAddress(`hsl(${280 + 10 * i} 70% ${20 + c * 10}%)`, place),
    };
  }));
}

const kCamera = {
  width: 1920, height: 1080, frames_per_second: 29.97, frames_in_file: 300, frames_kept: 300,
  pose_source: 'COLMAP', pose_error_px: 0.62, clock_offset_s: 0, clock_offset_frames: 0,
  clock_error_frames: 0.02, clock_source: 'audio', readout_s: 0, clock_learnt_s: null,
  readout_learnt_s: null, gain: 1.02, roll_degrees: -0.2, role: 'train', leave_out: false,
  notes: [],
};

/** One run; `better` is added to its PSNR, dB. */
export function runData({title = 'Küche, 30 steps <b>', better = 0, options = {}} = {}) {
  const often = steps(300, 100), seldom = steps(15, 2000);
  return {
    id: title, title, preset: 'default', seed: 7, version: '1.4.0', state: 'done', split: 'test',
    command: 'tessera run "Küche <1>" -o runs/kueche --preset default', host: 'zürich',
    started: '2026-11-24T09:30:12Z', cpu: 'AMD EPYC 9554, 16 cores',
    device: 'NVIDIA H100 80GB HBM3', steps: 30000,
    ingest_options: {cloud: 'default', scale: 1}, initial_points: '1000 points',
    options: {iterations: 30000, motion: 'nodes', learning_rate: 0.0016, crops: [1, 2], ...options},
    scores: {psnr: 30.456 + better, psnr_dynamic: 27.1 + better, psnr_static: 32.9 + better,
             psnr_fit: 33.2, ssim: 0.9312, lpips: 0.0874},
    verdict: 'sharp where it stands still, good where it moves',
    worst: {frame_number: 17, psnr: 26.02 + better},
    objects: [{name: 'ball', psnr: 29.4}, {name: 'Tänzerin', psnr: 25.8}],
    size: {static: 182345, dynamic: 45210, model_bytes: 51.2e6, player_bytes: 8.43e6,
           peak_bytes: 6.1e9},
    stages: [{name: 'read', seconds: 12.4}, {name: 'poses', seconds: 95},
             {name: 'train', seconds: 612.3}, {name: 'evaluate', seconds: 41},
             {name: 'export', seconds: 8.1}],
    seconds: {command: 772, training: 600},
    curves: {
      psnr_test: curve(seldom, (step) => 31 + better - 9 * Math.exp(-step / 5000)),
      psnr_validation: curve(steps(30, 1000), (step) => 30 + better - 8 * Math.exp(-step / 4000)),
      loss: curve(often, (step) => step === 500 ? 0 :
        0.02 + 0.2 * Math.exp(-step / 2500) * (1 + 0.2 * Math.sin(step))),
      static: curve(often, (step) => Math.round(182345 * (1 - Math.exp(-step / 6000)))),
      dynamic: curve(often, (step) => Math.round(45210 * (1 - Math.exp(-step / 9000)))),
      memory: curve(often, (step) => 6.1e9 * (1 - 0.8 * Math.exp(-step / 8000))),
    },
    views: views(better),
    cameras: [{...kCamera, name: 'cam00', role: 'test'},
              {...kCamera, name: 'cam01', clock_offset_s: 0.0417, clock_offset_frames: 1.25,
               clock_learnt_s: 0.0031,
               gain: null, notes: ['gain unknown', 'starts 1.25 frames late']}],
    decisions: [{step: 3000, text: 'Densification stops: 180k Gaussians are enough.',
                 static: [190000, 182345], dynamic: [50000, 45210]},
                {step: 12000, text: 'Motion nodes: 120 → 164, where the error is large.'}],
    warnings: [{stage: 'read', text: 'cam01 says </script><b>bold</b> & "ümläut"'}],
    files: [{name: 'Player', path: 'player 1#.html', bytes: 9.1e6},
            {name: 'Model', path: 'model.ply', bytes: 51.2e6},
            {name: 'Log', path: '../events.jsonl', bytes: null}],
    image_note: null,
  };
}

export function reportData(runs = [runData()]) {
  return {schema: 1, kind: runs.length > 1 ? 'comparison' : 'run', title: runs[0].title,
          version: '1.4.0', made: '2026-11-24T09:45:00Z', runs};
}

/** A clip in windows, of which one is not done. */
export function windowsData() {
  const run = runData({title: 'one minute'});
  run.curves = Object.fromEntries(Object.keys(run.curves).map((key) => [key, curve([], () => 0)]));
  run.decisions = [];
  run.windows = Array.from({length: 12}, (_, i) => ({
    folder: `windows/${String(i).padStart(4, '0')}`, begin: 5 * i, end: 5 * i + 5,
    state: i === 11 ? 'unfinished' : 'done', psnr: i === 11 ? null : 31 - ((i * 5) % 7),
    psnr_dynamic: i === 2 ? null : 24 + i / 10, psnr_static: 33, dynamic: 12345 + i, steps: 7000,
    seconds: i === 11 ? null : 81.2,
  }));
  run.borders = {inside: 1.5, border: 2.4, inside_moving: 25, border_moving: 26};
  return reportData([run]);
}

/** Two runs; the views of the second are in another order, and one is missing. */
export function comparisonData() {
  const second = runData({title: 'two', better: 1.2, options: {motion: 'pair', seed_points: 5}});
  second.views.reverse().pop();
  Object.assign(second, {ingest_options: {cloud: 'sparse', scale: 1}, initial_points: '90 points'});
  second.warnings.push({stage: 'train', text: 'few views'});
  second.files.push({name: 'Report', path: '../two/report/index.html', bytes: 9e5});
  return {...reportData([runData({title: 'one'}), second]), title: 'one and two'};
}

/** The built page with this data in it. */
export function pageWith(template, data) {
  const text = JSON.stringify(data).replace(/</g, '\\u003c');
  const element = /(<script id="tessera-report" type="application\/json">)null(<\/script>)/;
  return readFileSync(template, 'utf8').replace(element, (_, open, close) => open + text + close);
}
