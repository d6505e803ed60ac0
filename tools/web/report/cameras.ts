// The table of cameras, in the words of the terminal's.
import type { Camera, Run } from "./data";
import { make, section } from "./elements";
import { table, type Column } from "./tables";
import { fixed, UNKNOWN } from "./words";

const CAPTION =
  "frames: kept of those in the file; pose: mean reprojection error of COLMAP's points in " +
  "pixels, or where the pose comes from; clock: seconds (frames) added, and what they come from; " +
  "gain: brightness by the median camera's; roll: clockwise turn of the image.";

function signed(value: number, digits: number): string {
  return (value < 0 ? "" : "+") + value.toFixed(digits);
}

function clock(camera: Camera): string {
  if (camera.clock_offset_s === 0) return "0";
  const seconds = signed(camera.clock_offset_s, 4);
  if (camera.frames_per_second === null) return seconds;
  return `${seconds} (${signed(camera.clock_offset_frames, 2)})`;
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
  const odd = (camera: Camera) => (camera.notes.length > 0 ? "odd" : null);
  return section(
    "Cameras",
    make("div", { class: "card" }, table("cameras", COLUMNS, run.cameras, odd),
      make("p", { class: "soft" }, CAPTION)),
  );
}
