// The table of cameras, in the words of the terminal's.
import type { Camera, Run } from "./data";
import { make, section } from "./elements";
import { table, type Column } from "./tables";
import { fixed, UNKNOWN } from "./words";

const CAPTION =
  "frames: kept of those in the file; pose: mean reprojection error of COLMAP's points in " +
  "pixels, or where the pose comes from; clock: seconds (frames ± standard error) added, and what " +
  "they come from; learnt: what the training added to the clock, and to the time from the top row " +
  "of a rolling shutter to the bottom one; " +
  "gain: brightness by the median camera's; roll: clockwise turn of the image.";

function signed(value: number, digits: number): string {
  return (value < 0 ? "" : "+") + value.toFixed(digits);
}

function clock(camera: Camera): string {
  const { clock_offset_s: seconds, clock_error_frames: error } = camera;
  const frames: string[] = [];
  if (seconds !== 0 && camera.frames_per_second !== null)
    frames.push(signed(camera.clock_offset_frames, 2));
  if (error > 0) frames.push(`±${error.toFixed(2)}`);
  const text = seconds === 0 ? "0" : signed(seconds, 4);
  return frames.length > 0 ? `${text} (${frames.join("")})` : text;
}

/** Columns of what only some rigs have. */
function shutterColumns(cameras: Camera[]): Column<Camera>[] {
  const columns: [string, (camera: Camera) => number | null][] = [
    ["readout ms", (c) => c.readout_s || null],
    ["learnt clock ms", (c) => c.clock_learnt_s],
    ["learnt readout ms", (c) => c.readout_learnt_s],
  ];
  return columns
    .filter(([, seconds]) => cameras.some((camera) => seconds(camera) !== null))
    .map(([name, seconds]) => ({
      name,
      cell: (camera) => {
        const value = seconds(camera);
        return value === null ? UNKNOWN : signed(1000 * value, 1);
      },
    }));
}

const COLUMNS: Column<Camera>[] = [
  { name: "camera", cell: (c) => c.name },
  { name: "size", cell: (c) => `${c.width}x${c.height}` },
  {
    name: "fps",
    cell: (c) =>
      c.frames_per_second === null ? UNKNOWN : String(Math.round(100 * c.frames_per_second) / 100),
  },
  { name: "frames", cell: (c) => `${c.frames_kept}/${c.frames_in_file}` },
  {
    name: "pose px",
    cell: (c) => (c.pose_error_px === null ? c.pose_source : fixed(c.pose_error_px, 2)),
  },
  { name: "clock s (fr)", cell: clock },
  { name: "from", cell: (c) => c.clock_source || UNKNOWN },
  { name: "gain", cell: (c) => fixed(c.gain, 2) },
  {
    name: "roll",
    cell: (c) => (c.roll_degrees === null ? UNKNOWN : `${Math.round(c.roll_degrees) + 0}°`),
  },
  { name: "role", cell: (c) => c.role + (c.leave_out ? ", advised to leave out" : "") },
  { name: "notes", cell: (c) => c.notes.join(", ") || UNKNOWN },
];

export function camerasSection(run: Run): HTMLElement | null {
  if (run.cameras.length === 0) return null;
  const columns = [...COLUMNS.slice(0, 7), ...shutterColumns(run.cameras), ...COLUMNS.slice(7)];
  const odd = (camera: Camera) => (camera.notes.length > 0 ? "odd" : null);
  return section(
    "Cameras",
    make("div", { class: "card" }, table("cameras", columns, run.cameras, odd),
      make("p", { class: "soft" }, CAPTION)),
  );
}
