// The Pareto front of a report, its knee, and the ticks of its axes, on points with known answers.
import assert from 'node:assert/strict';
import {test} from 'node:test';

import {reportModules} from './player_modules.mjs';

const {kneeOf, linearTicks, paretoFront} = await reportModules('front', 'axes');

function points(...pairs) {
  return pairs.map(([cost, quality]) => ({cost, quality}));
}

// Finds: points as good as a cheaper one stay.
test('the front keeps what no other beats', () => {
  const five = points([100, 30], [1, 20], [20, 24], [10, 25], [12, 25]);
  assert.deepEqual(paretoFront(five), [1, 3, 0]);
  assert.deepEqual(paretoFront(points([5, 20], [5, 22], [5, 22])), [1], 'equal: the first');
  assert.deepEqual(paretoFront(points([1, 30], [10, 20])), [0], 'the cheapest is the best');
  assert.deepEqual(paretoFront([]), []);
});

// Finds: cost on a linear axis, which gives point 2; farthest on either side of the line.
test('the knee is farthest above the line', () => {
  const bent = points([1, 20], [10, 28], [100, 30], [1000, 30.5], [50, 27]);
  assert.equal(kneeOf(bent), 1);
  assert.equal(kneeOf(points([1, 20], [10, 21])), null, 'two points');
  assert.equal(kneeOf(points([1, 20], [10, 20.5], [100, 30])), null, 'bent the other way');
  assert.equal(kneeOf(points([10, 30], [20, 25], [30, 20])), null, 'one on the front');
});

// Finds: one tick for equal values.
test('linear ticks are round and surround the values', () => {
  assert.deepEqual(linearTicks(26.7, 31.3), [26, 28, 30, 32]);
  assert.deepEqual(linearTicks(0, 1), [0, 0.5, 1]);
  for (const [low, high] of [[30, 30], [0, 0], [-3.2, 7], [1e-4, 3e-4], [25.01, 25.02]]) {
    const ticks = linearTicks(low, high);
    assert.ok(ticks.length >= 2 && ticks.length <= 10, `${ticks}`);
    assert.ok(ticks[0] <= low && ticks[ticks.length - 1] >= high, `${low} ${high}: ${ticks}`);
  }
});
