// A chart as an image file: its title and the names of its lines above what is drawn.
import type { Line } from "./curve_points";
import { make, style } from "./elements";

const FONT = "system-ui, sans-serif";
const ROW = 18;

/** Where each name begins, in rows of the width. */
function places(lines: Line[], width: number, context: CanvasRenderingContext2D) {
  let left = 8;
  let row = 0;
  return lines.map(({ label, colour }) => {
    const room = context.measureText(label).width + 16;
    if (left > 8 && left + room > width) {
      left = 8;
      ++row;
    }
    left += room;
    return { label, colour, left: left - room, row };
  });
}

/** `drawn` is `width` wide in pixels of the page. */
export function chartImage(title: string, lines: Line[], drawn: HTMLCanvasElement, width: number) {
  const canvas = make("canvas");
  const context = canvas.getContext("2d")!;
  context.font = `12px ${FONT}`;
  const names = places(lines, width, context);
  const scale = drawn.width / width;
  const head = 32 + ROW * (1 + names[names.length - 1].row);
  canvas.width = drawn.width;
  canvas.height = drawn.height + Math.round(head * scale);
  context.fillStyle = style("--card");
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(drawn, 0, canvas.height - drawn.height);
  context.scale(scale, scale);
  context.fillStyle = style("--ink");
  context.font = `600 14px ${FONT}`;
  context.fillText(title, 8, 20);
  context.font = `12px ${FONT}`;
  for (const { label, colour, left, row } of names) {
    context.fillStyle = colour;
    context.fillText(label, left, 40 + ROW * row);
  }
  return canvas;
}
