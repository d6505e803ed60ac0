// Motion nodes at points chosen by farthest-point sampling, and splines whose quaternions have
// either sign.
#include "tests/browser/fixture_nodes.h"

#include <algorithm>

#include "recon4d/motion/nodes.h"

namespace tessera::testing {
namespace {

constexpr int64_t kNodes = 24;
constexpr int kKnots = 7;
constexpr int64_t kUnbound = 10;  // one Gaussian of so many

/// Most of what a control point adds to a node's place, world units, and to each part of its
/// quaternion.
constexpr double kShift = 0.25, kTilt = 0.7;

/// `set` with two more groups: no bindings yet.
GaussianSet as_canonical(const GaussianSet& set) {
  GaussianSet out(SetForm::kCanonical, set.coefficients());
  out.resize(set.count());
  const GaussianSpans<const float> from = set.values();
  const GaussianSpans<float> to = out.values();
  for (int g = 0; g < set.groups(); ++g)
    std::copy(from.group[g].begin(), from.group[g].end(), to.group[g].data);
  std::fill(to.group[kNode].begin(), to.group[kNode].end(), -1.0f);
  std::fill(to.group[kNodeLogit].begin(), to.group[kNodeLogit].end(), 0.0f);
  return out;
}

/// q and −q are one rotation: half of the nodes have the one, half the other, so that a blend
/// without regard to signs is seen.
void move_nodes(const NodePlan& plan, MotionNodes& nodes, Random& random) {
  const NodeSpans<float> to = nodes.spans();
  for (int64_t m = 0; m < nodes.count; ++m) {
    for (int c = 0; c < 3; ++c) to.position[3 * m + c] = plan.position[size_t(m)][c];
    to.log_radius[m] = plan.log_radius[size_t(m)];
    const double sign = m % 2 == 0 ? 1 : -1;
    for (int64_t i = m * kKnots; i < (m + 1) * kKnots; ++i) {
      for (int c = 0; c < 3; ++c)
        to.translation[3 * i + c] = float(random.uniform(-kShift, kShift));
      for (int c = 0; c < 4; ++c)
        to.rotation[4 * i + c] = float(sign * ((c == 0 ? 1 : 0) + random.uniform(-kTilt, kTilt)));
    }
  }
}

}  // namespace

void carry_by_nodes(GaussianModel& model, Random& random) {
  model.static_set = as_canonical(model.static_set);
  const GaussianSpans<float> set = model.static_set.values();
  const NodePlan plan = plan_nodes(set.group[kMean], set.group[kOpacityLogit], kNodes);
  model.nodes.resize(int64_t(plan.position.size()), kKnots);
  move_nodes(plan, model.nodes, random);
  for (int64_t n = 0; n < set.count; ++n) {
    if (n % kUnbound == 0) continue;
    const int64_t bound = 1 + n % kBindings;
    std::copy_n(plan.node.data() + n * kBindings, bound, set.at(kNode, n));
    for (int k = 0; k < bound; ++k) set.at(kNodeLogit, n)[k] = float(random.uniform(-1, 1));
  }
}

}  // namespace tessera::testing
