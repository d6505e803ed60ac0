// A chart of points with ranges, as SVG: quality against what it costs, with the Pareto front. The
// words of a point are shown under the cursor, and by arrow keys.
import { linearTicks, logarithmicTicks } from "./axes";
import { button, choice, make, save, style } from "./elements";
import { kneeOf, paretoFront } from "./front";
import { shortNumber } from "./words";

export interface Place {
  at: number;
  least: number;
  most: number;
}

export interface Dot {
  name: string;
  colour: string;
  hollow: boolean; // measured by others, on other machines: never on the front
  x: (Place | null)[]; // by axis; null: not known
  y: Place;
  words: string;
}

export interface Axis {
  name: string;
  unit: string;
  log: boolean;
}

const WIDTH = 640;
const HEIGHT = 340;
const LEFT = 52;
const RIGHT = 12;
const TOP = 10;
const BOTTOM = 40;
const SPACE = "http://www.w3.org/2000/svg";

function shape(tag: string, attributes: Record<string, string | number>, text = ""): SVGElement {
  const node = document.createElementNS(SPACE, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
  node.textContent = text;
  return node;
}

/** A value's share of the way from the first to the last tick. */
function scaleOf(ticks: number[], log: boolean): (value: number) => number {
  const size = (value: number) => (log ? Math.log(value) : value);
  const [low, high] = [size(ticks[0]), size(ticks[ticks.length - 1])];
  return (value) => (size(value) - low) / (high - low);
}

export class Scatter {
  readonly element: HTMLElement;
  private readonly svg = shape("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "scatter", tabindex: 0, role: "img",
  }) as SVGSVGElement;
  private readonly words = make("p", { class: "soft at", "aria-live": "polite" });
  private axis = 0;
  private shown: { dot: Dot; x: number; y: number; node: SVGElement }[] = [];
  private chosen = -1;

  /** `axes`: choices of x, each known for one point at least. */
  constructor(
    private readonly title: string,
    private readonly yName: string,
    private readonly axes: Axis[],
    private readonly dots: Dot[],
  ) {
    this.svg.setAttribute("aria-label", `${title}; arrow keys go through its points`);
    this.svg.addEventListener("pointermove", (event) => this.choose(this.nearest(event)));
    this.svg.addEventListener("pointerdown", (event) => this.choose(this.nearest(event)));
    this.svg.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (step === undefined || this.shown.length === 0) return;
      event.preventDefault();
      const next = this.chosen < 0 ? 0 : this.chosen + step;
      this.choose(Math.min(this.shown.length - 1, Math.max(0, next)));
    });
    this.element = make("figure", { class: "card chart", "aria-label": title },
      make("header", {}, make("h3", {}, title),
        axes.length > 1
          ? choice("x axis", axes.map(({ name }) => name), (index) => this.draw(index))
          : null,
        button("SVG", () => this.saveSvg(), { "aria-label": `SVG of ${title}` })),
      make("div", {}, this.svg), this.words);
    this.draw(0);
  }

  private draw(axis: number): void {
    this.axis = axis;
    const dots = this.dots.filter((dot) => dot.x[axis] !== null);
    const { log } = this.axes[axis];
    const ends = (places: Place[]): [number, number] =>
      [Math.min(...places.map(({ least }) => least)), Math.max(...places.map(({ most }) => most))];
    const [low, high] = ends(dots.map((dot) => dot.x[axis]!));
    const xTicks = log ? logarithmicTicks(low, high) : linearTicks(low, high);
    const yTicks = linearTicks(...ends(dots.map(({ y }) => y)));
    const [xShare, yShare] = [scaleOf(xTicks, log), scaleOf(yTicks, false)];
    const x = (value: number) => LEFT + xShare(value) * (WIDTH - LEFT - RIGHT);
    const y = (value: number) => HEIGHT - BOTTOM - yShare(value) * (HEIGHT - TOP - BOTTOM);
    const measured = dots.filter(({ hollow }) => !hollow);
    const priced = measured.map((dot) => ({ cost: dot.x[axis]!.at, quality: dot.y.at }));
    const front = paretoFront(priced).map((i) => `${x(priced[i].cost)},${y(priced[i].quality)}`);
    const line = shape("polyline", { points: front.join(" "), class: "front" });
    this.svg.replaceChildren(...this.frame(xTicks, yTicks, x, y), line);
    const knee = kneeOf(priced);
    this.shown = dots
      .map((dot) => ({ dot, ...this.mark(dot, x, y, knee !== null && dot === measured[knee]) }))
      .sort((a, b) => a.x - b.x);
    this.choose(-1);
  }

  private frame(xTicks: number[], yTicks: number[], x: (v: number) => number,
    y: (v: number) => number): SVGElement[] {
    const bottom = HEIGHT - BOTTOM;
    const { name, unit } = this.axes[this.axis];
    const parts: SVGElement[] = [];
    for (const tick of xTicks)
      parts.push(shape("line", { x1: x(tick), x2: x(tick), y1: TOP, y2: bottom, class: "grid" }),
        shape("text", { x: x(tick), y: bottom + 16, "text-anchor": "middle" }, shortNumber(tick)));
    for (const tick of yTicks)
      parts.push(
        shape("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: y(tick), y2: y(tick), class: "grid" }),
        shape("text", { x: LEFT - 6, y: y(tick) + 4, "text-anchor": "end" }, shortNumber(tick)));
    const middle = (TOP + bottom) / 2;
    parts.push(
      shape("text", { x: (LEFT + WIDTH) / 2, y: HEIGHT - 4, "text-anchor": "middle" },
        `${name} [${unit}]`),
      shape("text", { x: 12, y: middle, "text-anchor": "middle",
        transform: `rotate(-90 12 ${middle})` }, this.yName));
    return parts;
  }

  /** The knee has the larger circle. */
  private mark(dot: Dot, x: (v: number) => number, y: (v: number) => number, knee: boolean) {
    const place = dot.x[this.axis]!;
    const [cx, cy] = [x(place.at), y(dot.y.at)];
    const node = shape("g", { stroke: dot.colour });
    node.append(
      shape("line", { x1: x(place.least), x2: x(place.most), y1: cy, y2: cy }),
      shape("line", { x1: cx, x2: cx, y1: y(dot.y.least), y2: y(dot.y.most) }),
      shape("circle", { cx, cy, r: knee ? 8 : 5,
        fill: dot.hollow ? style("--card") : dot.colour }),
      this.label(dot, cx, cy));
    this.svg.append(node);
    return { x: cx, y: cy, node };
  }

  private label(dot: Dot, cx: number, cy: number): SVGElement {
    const left = cx > 0.75 * WIDTH;
    return shape("text", { x: left ? cx - 10 : cx + 10, y: cy - 8, class: "name",
      "text-anchor": left ? "end" : "start" }, dot.name);
  }

  private nearest(event: PointerEvent): number {
    const box = this.svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * WIDTH;
    const y = ((event.clientY - box.top) / box.height) * HEIGHT;
    const far = this.shown.map((shown) => Math.hypot(shown.x - x, shown.y - y));
    return far.indexOf(Math.min(...far));
  }

  private choose(index: number): void {
    this.chosen = index;
    this.shown.forEach(({ node }, i) => node.classList.toggle("chosen", i === index));
    this.words.textContent = index >= 0 ? this.shown[index].dot.words
      : "Point at a mark for its values. Dashed: the front; large: more cost begins to buy little.";
  }

  private saveSvg(): void {
    const copy = this.svg.cloneNode(true) as SVGSVGElement;
    copy.setAttribute("xmlns", SPACE);
    const rules = `text{font:12px sans-serif;stroke:none;fill:${style("--ink")}}` +
      `.grid{stroke:${style("--line")}}.front{fill:none;stroke:${style("--soft")}}`;
    copy.prepend(shape("rect", { width: WIDTH, height: HEIGHT, fill: style("--card") }),
      shape("style", {}, rules));
    save(`${this.title}.svg`, new Blob([copy.outerHTML], { type: "image/svg+xml" }));
  }
}
