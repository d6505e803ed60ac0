// The Pareto front of cost and quality, and the point of it where more cost begins to buy little.
export interface Priced {
  cost: number; // > 0
  quality: number;
}

/** Indices of the points that no other is at least as cheap and at least as good as (of equal ones
 * the first), from the cheapest to the best. */
export function paretoFront(points: Priced[]): number[] {
  const order = points.map((_, i) => i).sort((a, b) =>
    points[a].cost - points[b].cost || points[b].quality - points[a].quality || a - b);
  const front: number[] = [];
  for (const i of order)
    if (front.length === 0 || points[i].quality > points[front[front.length - 1]].quality)
      front.push(i);
  return front;
}

/** The point of the front farthest above the straight line from its cheapest to its best point, with
 * log(cost) and quality each scaled to [0, 1] between these two; null where the front has fewer than
 * three points or none is above the line. */
export function kneeOf(points: Priced[]): number | null {
  const front = paretoFront(points);
  if (front.length < 3) return null;
  const first = points[front[0]];
  const last = points[front[front.length - 1]];
  const above = (i: number) =>
    (points[i].quality - first.quality) / (last.quality - first.quality) -
    Math.log(points[i].cost / first.cost) / Math.log(last.cost / first.cost);
  const knee = front.reduce((best, i) => (above(i) > above(best) ? i : best));
  return above(knee) > 0 ? knee : null;
}
