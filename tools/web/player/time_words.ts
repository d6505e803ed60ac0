// The text of the page's clock: seconds with their unit, and the number of the frame where the
// capture's frame rate or the times of its frames are known.

/** Images of the last second. */
export class ImageRate {
  private readonly times: number[] = []; // ms

  /** To be called for each image. */
  count(now: number): number {
    this.times.push(now);
    while (now - this.times[0] >= 1000) this.times.shift();
    return this.times.length;
  }
}

export interface Clip {
  duration: number; // seconds
  fps: number | null; // of the capture
  frames: number[] | null; // of a sequence: their times in t, ascending
}

function nearest(times: number[], t: number): number {
  return times.reduce(
    (best, time, i) => (Math.abs(time - t) < Math.abs(times[best] - t) ? i : best),
    0,
  );
}

/** The frame that is nearest to a time, from 0; of a sequence, or of the capture's frame rate. */
export function frameAt(clip: Clip, seconds: number): number | null {
  const { duration, fps, frames } = clip;
  if (frames !== null) return nearest(frames, duration > 0 ? seconds / duration : 0);
  return fps === null ? null : Math.round(seconds * fps);
}

/** "frame 8 / 24", counted from 1; null where frames are not known. */
export function frameWords(clip: Clip, seconds: number): string | null {
  const frame = frameAt(clip, seconds);
  if (frame === null) return null;
  const last = clip.frames?.length ?? frameAt(clip, clip.duration)! + 1;
  return `frame ${frame + 1} / ${last}`;
}

/** "0.35 s / 0.96 s" */
export function timeWords(clip: Clip, seconds: number): string {
  return `${seconds.toFixed(2)} s / ${clip.duration.toFixed(2)} s`;
}
