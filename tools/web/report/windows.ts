// A clip that was trained window by window: how its windows differ, and what is seen at their borders.
import type { Run, Window } from "./data";
import { details, make, section } from "./elements";
import { table, type Column } from "./tables";
import { decibels, fixed, shortNumber, timeWords, wholeNumber } from "./words";

export type Tile = [name: string, value: string, more: string];

function place(window: Window): string {
  return `${window.begin.toFixed(1)} to ${window.end.toFixed(1)} s`;
}

/** The window of the lowest PSNR, and the change of the error from one window to the next. */
export function windowTiles(run: Run): Tile[] {
  const tiles: Tile[] = [];
  const windows = run.windows ?? [];
  const scored = windows.filter((window) => window.psnr !== null);
  if (scored.length > 1) {
    const lowest = scored.reduce((a, b) => (b.psnr! < a.psnr! ? b : a));
    tiles.push(["Lowest window", decibels(lowest.psnr),
      `number ${windows.indexOf(lowest) + 1}, ${place(lowest)}`]);
  }
  const { inside, border, inside_moving, border_moving } = run.borders ?? {};
  if (inside && border) {
    const moving = inside_moving && border_moving
      ? `moving pixels ${fixed(border_moving / inside_moving, 2)} ×; ` : "";
    tiles.push(["Borders of windows", `${fixed(border / inside, 2)} ×`,
      `${moving}temporal error by that inside windows`]);
  }
  return tiles;
}

export function windowsSection(run: Run): HTMLElement | null {
  const windows = run.windows ?? [];
  if (windows.length === 0) return null;
  const number = (name: string, order: (window: Window) => number | null,
    cell: (value: number | null) => string): Column<Window> => ({
    name, number: true, order, cell: (window) => cell(order(window)),
  });
  const score = (value: number | null) => fixed(value, 2);
  const count = (value: number | null) => shortNumber(value ?? 0);
  const columns: Column<Window>[] = [
    number("window", (window) => windows.indexOf(window) + 1, (value) => wholeNumber(value!)),
    { name: "time", order: (window) => window.begin, cell: place },
    number("PSNR [dB]", (window) => window.psnr, score),
    number("moving pixels [dB]", (window) => window.psnr_dynamic, score),
    number("static pixels [dB]", (window) => window.psnr_static, score),
    number("dynamic Gaussians", (window) => window.dynamic, count),
    number("steps", (window) => window.steps, count),
    number("training", (window) => window.seconds, timeWords),
    { name: "state", order: (window) => window.state, cell: (window) => window.state },
  ];
  return section("Windows", make("div", { class: "card" },
    details(`${windows.length} windows with their scores`, table("windows", columns, windows)),
    make("p", { class: "soft" }, "Curves and decisions are those of one training: ",
      make("code", {}, `tessera report RUN/${windows[0].folder}`), ".")));
}
