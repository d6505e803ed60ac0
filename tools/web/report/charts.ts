// The charts of one run or of several, which share x, zoom and cursor.
import { Chart, type ChartContent } from "./chart";
import { extent, type Line, type XName } from "./curve_points";
import type { CurveName, Run } from "./data";
import { button, choice, make, section } from "./elements";
import { decibels, fixed, shortNumber } from "./words";

/** Of Okabe and Ito, without those that a light or a dark ground hides; then grey and olive. */
export const COLOURS = [
  "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8A8F99", "#999933",
];

const TITLES: Omit<ChartContent, "lines">[] = [
  { name: "psnr", title: "PSNR [dB]", log: false, words: (value) => decibels(value) },
  { name: "loss", title: "Loss", log: true, words: shortNumber },
  { name: "gaussians", title: "Gaussians", log: false, words: shortNumber },
  { name: "memory", title: "Memory [MB]", log: false, words: (value) => `${fixed(value, 0)} MB` },
];
const CURVES: [CurveName, string][][] = [
  [["psnr_test", "test views"], ["psnr_validation", "validation views"]],
  [["loss", "training loss"]],
  [["static", "static"], ["dynamic", "dynamic"]],
  [["memory", "peak of the device"]],
];

/** By what runs share a colour and a name in the legend. */
export type GroupOf = (run: Run) => string;

/** Several runs: a colour and a name for each group, and the second curve of a chart dashed. */
function linesOf(runs: Run[], curves: [CurveName, string][], groupOf: GroupOf): Line[] {
  const groups = [...new Set(runs.map(groupOf))];
  const alone = (group: string) => runs.filter((run) => groupOf(run) === group).length === 1;
  return runs.flatMap((run) =>
    curves.flatMap(([name, words], c) => {
      const raw = run.curves[name];
      if (raw === undefined || raw.step.length === 0) return [];
      const curve =
        name === "memory" ? { ...raw, value: raw.value.map((bytes) => bytes / 1e6) } : raw;
      const several = runs.length > 1;
      const group = groupOf(run);
      const nameOf = (title: string) =>
        !several ? words : curves.length > 1 ? `${title}, ${words}` : title;
      return {
        label: nameOf(run.title),
        colour: COLOURS[(several ? groups.indexOf(group) : c) % COLOURS.length],
        dashed: several && c > 0,
        name: nameOf(alone(group) ? run.title : group),
        curve,
      };
    }),
  );
}

/** Draws all anew when the colours of the page change. */
function followColours(charts: Chart[]): void {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const chart of charts) chart.redraw();
  });
}

function contentsOf(runs: Run[], groupOf: GroupOf): ChartContent[] {
  return TITLES.map((title, i) => ({ ...title, lines: linesOf(runs, CURVES[i], groupOf) }))
    .filter(({ lines }) => lines.length > 0);
}

export interface Charts {
  element: HTMLElement;
  /** New values of the same curves, under the zoom and the cursor that are there; false where there
   * are other curves. */
  show(runs: Run[]): boolean;
}

export function makeCharts(runs: Run[], groupOf: GroupOf = (run) => run.id): Charts | null {
  const zoom = (low: number, high: number) => charts.forEach((chart) => chart.setRange(low, high));
  const charts = contentsOf(runs, groupOf).map((content) => new Chart(content, zoom));
  if (charts.length === 0) return null;
  const linesNow = () => charts.flatMap((chart) => chart.content.lines);
  let x: XName = "step";
  const setX = (name: XName) => {
    x = name;
    const ends = extent(linesNow(), x);
    for (const chart of charts) chart.setX(x, ends);
  };
  const show = (now: Run[]) => {
    const contents = contentsOf(now, groupOf);
    const same = ({ content: { name, lines } }: Chart, i: number) =>
      name === contents[i].name && lines.length === contents[i].lines.length;
    if (contents.length !== charts.length || !charts.every(same)) return false;
    const ends = extent(contents.flatMap(({ lines }) => lines), x);
    charts.forEach((chart, i) => chart.update(contents[i].lines, ends));
    return true;
  };
  const hasSeconds = charts.every((chart) => {
    const ends = extent(chart.content.lines, "seconds");
    return ends !== null && ends[0] < ends[1];
  });
  setX("step");
  followColours(charts);
  const element = section(
    "Training",
    make(
      "div",
      { class: "bar" },
      hasSeconds
        ? choice("x axis", ["steps", "seconds"], (index) => setX(index === 1 ? "seconds" : "step"))
        : null,
      button("Whole range", () => charts.forEach((chart) => chart.reset())),
      make("span", { class: "soft" }, "Drag or pinch to zoom; a double click shows all."),
    ),
    make("div", { class: "charts" }, ...charts.map((chart) => chart.element)),
  );
  return { element, show };
}
