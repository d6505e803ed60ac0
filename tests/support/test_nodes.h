// Motion nodes of tests: owned arrays of any scalar type, random ones, and sets that are bound to
// them.
#pragma once
#include <vector>

#include "kernels/motion_nodes.h"
#include "tests/support/random.h"

namespace tessera::testing {

template <class Real>
struct TestNodes {
  int64_t count = 0;
  int knots = 0;
  std::vector<Real> position, log_radius, translation, rotation;  // as NodeSpans

  /// Zeros, for gradients.
  TestNodes like() const {
    TestNodes out = *this;
    for (std::vector<Real>* values : out.arrays())
      std::fill(values->begin(), values->end(), Real(0));
    return out;
  }
  std::vector<std::vector<Real>*> arrays() {
    return {&position, &log_radius, &translation, &rotation};
  }
  template <class To>
  TestNodes<To> as() const {
    return {count,
            knots,
            {position.begin(), position.end()},
            {log_radius.begin(), log_radius.end()},
            {translation.begin(), translation.end()},
            {rotation.begin(), rotation.end()}};
  }
};

/// Nodes in a ball of radius 1 that move and turn clearly.
inline TestNodes<double> random_nodes(int64_t count, int knots, Random& random) {
  TestNodes<double> nodes;
  nodes.count = count;
  nodes.knots = knots;
  for (int64_t m = 0; m < count; ++m) {
    for (int c = 0; c < 3; ++c) nodes.position.push_back(random.uniform(-0.8, 0.8));
    nodes.log_radius.push_back(random.uniform(-1.5, -0.5));
    for (int i = 0; i < knots; ++i) {
      for (int c = 0; c < 3; ++c) nodes.translation.push_back(random.uniform(-0.3, 0.3));
      for (int c = 0; c < 4; ++c)
        nodes.rotation.push_back((c == 0 ? 1 : 0) + random.uniform(-0.3, 0.3));
    }
  }
  return nodes;
}

/// Nodes that leave everything where it is.
inline TestNodes<double> nodes_at_rest(int64_t count, int knots, Random& random) {
  TestNodes<double> nodes = random_nodes(count, knots, random);
  std::fill(nodes.translation.begin(), nodes.translation.end(), 0.0);
  for (size_t i = 0; i < nodes.rotation.size(); ++i) nodes.rotation[i] = i % 4 == 0 ? 1 : 0;
  return nodes;
}

/// A static set as a canonical one. Gaussian n is bound to `bound(n)` of its nearest nodes, at most
/// kBindings, with random logits.
template <class Bound>
TestGaussians<double> canonical(TestGaussians<double> set, const TestNodes<double>& nodes,
                                Random& random, Bound&& bound) {
  set.form = SetForm::kCanonical;
  set.group[kNode].assign(size_t(set.count * kBindings), -1);
  set.group[kNodeLogit].assign(size_t(set.count * kBindings), 0);
  for (int64_t n = 0; n < set.count; ++n) {
    std::vector<std::pair<double, int64_t>> nearest;
    for (int64_t m = 0; m < nodes.count; ++m) {
      double distance2 = 0;
      for (int c = 0; c < 3; ++c) {
        const double offset = set.at(kMean, n)[c] - nodes.position[size_t(3 * m + c)];
        distance2 += offset * offset;
      }
      nearest.emplace_back(distance2, m);
    }
    std::sort(nearest.begin(), nearest.end());
    const int64_t wanted = std::min<int64_t>({bound(n), nodes.count, kBindings});
    for (int64_t k = 0; k < wanted; ++k) {
      set.at(kNode, n)[k] = double(nearest[size_t(k)].second);
      set.at(kNodeLogit, n)[k] = random.uniform(-1, 1);
    }
  }
  return set;
}

}  // namespace tessera::testing
