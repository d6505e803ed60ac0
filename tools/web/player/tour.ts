// The order of a short closed tour of places: repeatedly the nearest place that is left, then
// reversals of stretches as long as they shorten the tour (2-opt).
import type * as THREE from "three";

const GAIN = 1e-9; // of the whole way: shorter by less is by rounding

function nearestFirst(places: THREE.Vector3[]): number[] {
  const left = new Set(places.keys());
  const order: number[] = [];
  for (let next = 0; left.size > 0; ) {
    order.push(next);
    left.delete(next);
    let least = Infinity;
    for (const i of left) {
      const distance = places[i].distanceTo(places[order[order.length - 1]]);
      if (distance < least) [least, next] = [distance, i];
    }
  }
  return order;
}

/** Indices of the places, each once, the first one first. */
export function tourOf(places: THREE.Vector3[]): number[] {
  const order = places.length > 0 ? nearestFirst(places) : [];
  const count = order.length;
  const stop = (k: number) => places[order[k % count]];
  const leg = (a: number, b: number) => stop(a).distanceTo(stop(b));
  const least = GAIN * order.reduce((sum, _, k) => sum + leg(k, k + 1), 0);
  for (let shorter = true; shorter; ) {
    shorter = false;
    for (let i = 0; i + 2 < count; ++i)
      for (let k = i + 2; k < count; ++k) {
        if (leg(i, k) + leg(i + 1, k + 1) >= leg(i, i + 1) + leg(k, k + 1) - least) continue;
        order.splice(i + 1, k - i, ...order.slice(i + 1, k + 1).reverse());
        shorter = true;
      }
  }
  return order;
}
