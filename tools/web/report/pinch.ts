// Touch on a chart: one finger shows values, two fingers zoom and move x.
import type uPlot from "uplot";

/** `zoom` is told the range in which the values under both fingers stay there. */
export function pinch(plot: uPlot, zoom: (low: number, high: number) => void): void {
  const fingers = new Map<number, PointerEvent>();
  let held: [number, number] | null = null; // values under the fingers, from left to right
  const places = () => {
    const left = plot.over.getBoundingClientRect().left;
    return [...fingers.values()].map((finger) => finger.clientX - left).sort((a, b) => a - b);
  };
  plot.over.style.touchAction = "pan-y";
  plot.over.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "touch") return;
    fingers.set(event.pointerId, event);
    if (fingers.size === 2) held = places().map((at) => plot.posToVal(at, "x")) as [number, number];
  });
  plot.over.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    fingers.set(event.pointerId, event);
    const [first, second] = places();
    if (fingers.size === 1) plot.setCursor({ left: first, top: 0 });
    if (fingers.size !== 2 || held === null || second - first < 10) return;
    const perPixel = (held[1] - held[0]) / (second - first);
    const low = held[0] - first * perPixel;
    const high = low + plot.over.clientWidth * perPixel;
    const xs = plot.data[0];
    zoom(Math.max(low, xs[0]), Math.min(high, xs[xs.length - 1]));
  });
  for (const end of ["pointerup", "pointercancel"] as const)
    plot.over.addEventListener(end, (event) => {
      fingers.delete(event.pointerId);
      held = null;
    });
}
