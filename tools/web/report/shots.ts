// The rendered views of one run or of several, paired by name.
import type { Run, View } from "./data";

export interface Shot {
  name: string;
  camera: string;
  time: number;
  width: number;
  height: number;
  role: View["role"]; // of the first run that has the view
  strip: boolean;
  truth: string | null;
  views: (View | null)[]; // by run
}

/** Views of which some run has an image, by camera and time. */
export function shotsOf(runs: Run[]): Shot[] {
  const shots = new Map<string, Shot>();
  runs.forEach((run, r) => {
    for (const view of run.views) {
      if (view.truth === null && view.result === null) continue;
      const { name, camera, time, width, height, role } = view;
      const shot = shots.get(name) ?? {
        name, camera, time, width, height, role, strip: false, truth: null,
        views: runs.map(() => null),
      };
      shot.views[r] = view;
      shot.truth ??= view.truth;
      shot.strip ||= view.strip;
      shots.set(name, shot);
    }
  });
  return [...shots.values()].sort(
    (a, b) => a.camera.localeCompare(b.camera, "en", { numeric: true }) || a.time - b.time,
  );
}
