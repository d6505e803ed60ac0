// One chart over steps or seconds, drawn by uPlot: its axes, zoom, and values under the cursor.
import uPlot from "uplot";
import { logarithmicRange, logarithmicTicks } from "./axes";
import { chartImage } from "./chart_image";
import { columns, csv, type Line, type XName } from "./curve_points";
import { button, choice, make, save, style } from "./elements";
import { pinch } from "./pinch";
import { shortNumber } from "./words";

export interface ChartContent {
  name: string; // of its files
  title: string;
  log: boolean;
  lines: Line[];
  words: (value: number) => string; // a value with its unit
}

const HEIGHT = 260;
const FEW_POINTS = 40; // of a line, which shows each
const DASHES = [6, 4];

/** `zoom` is told the range of x that two fingers ask for. */
export class Chart {
  readonly element: HTMLElement;
  private readonly place = make("div", { class: "plot" });
  private readonly under = make("span", { class: "at" });
  private readonly values: HTMLElement[];
  private plot: uPlot | null = null;
  private x: XName = "step";
  private ends: [number, number] = [0, 1];
  private log: boolean;

  constructor(
    readonly content: ChartContent,
    private readonly zoom: (low: number, high: number) => void,
  ) {
    this.log = content.log;
    this.values = content.lines.map(() => make("b"));
    const setLog = (index: number) => this.setLog(index === 1);
    const scale = choice("y axis", ["linear", "log"], setLog, Number(this.log));
    this.element = make(
      "figure",
      { class: "card chart", "aria-label": content.title },
      make(
        "header",
        {},
        make("h3", {}, content.title),
        scale,
        button("PNG", () => this.savePng(), { "aria-label": `PNG of ${content.title}` }),
        button("CSV", () => this.saveCsv(), { "aria-label": `CSV of ${content.title}` }),
      ),
      this.legend(),
      this.place,
    );
    new ResizeObserver(() => this.resize()).observe(this.place);
  }

  setX(x: XName, ends: [number, number] | null): void {
    this.x = x;
    this.ends = ends ?? [0, 1];
    this.draw();
  }

  /** New values of the same lines; a range that was zoomed to stays. */
  update(lines: Line[], ends: [number, number] | null): void {
    const { min, max } = this.plot?.scales.x ?? {};
    const zoomed = min != null && max != null && (min > this.ends[0] || max < this.ends[1]);
    this.content.lines = lines;
    this.ends = ends ?? [0, 1];
    const data = columns(lines, this.x, this.ends, this.log);
    this.plot?.setData(data as uPlot.AlignedData, !zoomed);
    if (this.plot) this.showValues(this.plot);
  }

  setRange(low: number, high: number): void {
    this.plot?.setScale("x", { min: low, max: high });
  }

  reset(): void {
    this.setRange(...this.ends);
  }

  /** In the colours of the page now. */
  redraw(): void {
    this.plot?.redraw();
  }

  private setLog(log: boolean): void {
    const { min, max } = this.plot?.scales.x ?? {};
    this.log = log;
    this.draw();
    if (min != null && max != null) this.setRange(min, max);
  }

  private legend(): HTMLElement {
    const entries = new Map<string, HTMLElement>();
    this.content.lines.forEach(({ name, label, colour, dashed }, i) => {
      const key = make("i", { class: dashed ? "key dashed" : "key" });
      key.style.setProperty("--key", colour);
      if (!entries.has(name)) entries.set(name, make("span", {}, key, name));
      this.values[i].title = label;
      entries.get(name)!.append(" ", this.values[i]);
    });
    return make("figcaption", { class: "legend" }, ...entries.values(), this.under);
  }

  private resize(): void {
    const width = this.place.clientWidth;
    if (width > 0 && width !== this.plot?.width) this.plot?.setSize({ width, height: HEIGHT });
  }

  private draw(): void {
    this.plot?.destroy();
    const data = columns(this.content.lines, this.x, this.ends, this.log);
    this.plot = new uPlot(this.options(data), data as uPlot.AlignedData, this.place);
    pinch(this.plot, this.zoom);
    this.showValues(this.plot);
  }

  private options(data: (number | null)[][]): uPlot.Options {
    const axis = {
      stroke: () => style("--soft"),
      grid: { stroke: () => style("--line"), width: 1 },
      ticks: { stroke: () => style("--line"), width: 1, size: 5 },
      font: "12px system-ui, sans-serif",
      labelFont: "12px system-ui, sans-serif",
    };
    const numbers = (_: uPlot, ticks: (number | null)[]) =>
      ticks.map((tick) => (tick === null ? null : shortNumber(tick)));
    const logAxis = {
      splits: (_: uPlot, _axis: number, low: number, high: number) => logarithmicTicks(low, high),
      filter: (_: uPlot, splits: number[]) => splits,
    };
    return {
      width: Math.max(this.place.clientWidth, 200),
      height: HEIGHT,
      legend: { show: false },
      scales: {
        x: { time: false },
        y: this.log ? { distr: 3, range: (_, low, high) => logarithmicRange(low, high) } : {},
      },
      axes: [
        { ...axis, values: numbers, label: this.x === "step" ? "step" : "seconds of training",
          labelSize: 18, size: 32, space: 60 },
        { ...axis, values: numbers, size: 56, ...(this.log ? logAxis : {}) },
      ],
      series: [{}, ...this.content.lines.map((line, i) => this.series(line, data[i + 1]))],
      cursor: {
        drag: { x: true, y: false, dist: 6 },
        sync: { key: "report", scales: ["x", null] },
        hover: { skip: [null, undefined] },
        y: false,
      },
      hooks: { setCursor: [(plot) => this.showValues(plot)] },
    };
  }

  private series(line: Line, values: (number | null)[]): uPlot.Series {
    const count = values.filter((value) => value !== null).length;
    return {
      label: line.label,
      stroke: line.colour,
      width: 2,
      spanGaps: true,
      points: { show: count <= FEW_POINTS, size: 5, fill: line.colour },
      ...(line.dashed ? { dash: DASHES } : {}),
    };
  }

  /** The values under the cursor; without one, the last of each line. */
  private showValues(plot: uPlot): void {
    const under = plot.cursor.idx ?? null;
    this.values.forEach((node, i) => {
      const column = plot.data[i + 1] as (number | null)[];
      const known = column.filter((number) => number !== null);
      const index = plot.cursor.idxs?.[i + 1] ?? -1;
      const value = (under === null ? known[known.length - 1] : column[index]) ?? null;
      node.textContent = value === null ? "–" : this.content.words(value);
    });
    const unit = this.x === "step" ? "step" : "second";
    this.under.textContent =
      under === null ? "last values" : `${unit} ${shortNumber(plot.data[0][under])}`;
  }

  private saveCsv(): void {
    const text = csv(this.content.lines, this.x);
    save(`${this.content.name}.csv`, new Blob([text], { type: "text/csv" }));
  }

  private savePng(): void {
    const { name, title, lines } = this.content;
    const { ctx, width } = this.plot!;
    chartImage(title, lines, ctx.canvas, width).toBlob(
      (image) => image !== null && save(`${name}.png`, image),
    );
  }
}
