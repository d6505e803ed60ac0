// Farthest-point sampling and nearest nodes for the start of motion nodes, and least squares over
// times of the clip for more control points, in double on the host.
#include "recon4d/motion/nodes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/base/cholesky.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"

namespace tessera {
namespace {

constexpr float kMinOpacity = 0.1f, kFaintest = 0.01f;
constexpr int64_t kElementsPerNode = 4;

float squared_distance(const Vec3<float>& a, const Vec3<float>& b) {
  const Vec3<float> offset = a - b;
  return dot(offset, offset);
}

/// Elements that may become nodes, by their number, and how far from the centre they may lie.
struct Eligible {
  std::vector<int64_t> elements;
  Vec3<float> centre{0.0f};
  float reach = 0;  // world units
};

/// The logit of the `wanted` most opaque elements, or of all, that is the smallest.
float least_of_most_opaque(Span<const float> opacity_logit, int64_t wanted) {
  std::vector<float> logits(opacity_logit.data, opacity_logit.data + opacity_logit.size);
  const auto last = logits.begin() + std::min(wanted, opacity_logit.size) - 1;
  std::nth_element(logits.begin(), last, logits.end(), std::greater<>());
  return *last;
}

/// `wanted`: elements, where fewer are more opaque than kMinOpacity, as soon after the start.
Eligible eligible_elements(Span<const float> mean, Span<const float> opacity_logit,
                           int64_t wanted) {
  constexpr float kReach = 3;  // by the median: a few strays lie far away
  Eligible eligible;
  std::vector<int64_t> opaque;
  if (opacity_logit.size == 0 || wanted == 0) return eligible;
  const float least = least_of_most_opaque(opacity_logit, wanted);
  for (int64_t n = 0; n < opacity_logit.size; ++n) {
    const float o = opacity_logit[n];
    if (o > logit(kMinOpacity) || (o >= least && o > logit(kFaintest))) opaque.push_back(n);
  }
  if (opaque.empty()) return eligible;
  std::vector<float> values;
  for (int c = 0; c < 3; ++c) {
    values.clear();
    for (const int64_t n : opaque) values.push_back(mean[3 * n + c]);
    eligible.centre[c] = median(values);
  }
  values.clear();
  for (const int64_t n : opaque)
    values.push_back(squared_distance(load3(mean.data + 3 * n), eligible.centre));
  eligible.reach = kReach * std::sqrt(median(values));
  for (size_t i = 0; i < opaque.size(); ++i)
    if (values[i] <= eligible.reach * eligible.reach) eligible.elements.push_back(opaque[i]);
  return eligible;
}

std::vector<Vec3<float>> farthest_points(Span<const float> mean, const Eligible& eligible,
                                         int64_t count) {
  const std::vector<int64_t>& elements = eligible.elements;
  std::vector<Vec3<float>> chosen;
  std::vector<float> nearest(elements.size(), std::numeric_limits<float>::max());
  Vec3<float> last = eligible.centre;
  bool first = true;
  while (int64_t(chosen.size()) < count) {
    size_t farthest = 0;
    float most = 0;
    for (size_t i = 0; i < elements.size(); ++i) {
      const float distance = squared_distance(load3(mean.data + 3 * elements[i]), last);
      nearest[i] = first ? distance : std::min(nearest[i], distance);
      if (nearest[i] > most) {
        most = nearest[i];
        farthest = i;
      }
    }
    if (most == 0 && !first) break;  // all others lie on nodes
    last = load3(mean.data + 3 * elements[farthest]);
    if (first) std::fill(nearest.begin(), nearest.end(), std::numeric_limits<float>::max());
    first = false;
    chosen.push_back(last);
  }
  return chosen;
}

/// Numbers of the `count` nodes nearest to a point, nearest first; of all where there are fewer.
std::vector<int> nearest_nodes(const std::vector<Vec3<float>>& nodes, const Vec3<float>& point,
                               size_t count) {
  std::vector<std::pair<float, int>> by_distance;
  by_distance.reserve(nodes.size());
  for (size_t m = 0; m < nodes.size(); ++m)
    by_distance.emplace_back(squared_distance(nodes[m], point), int(m));
  count = std::min(count, nodes.size());
  std::partial_sort(by_distance.begin(), by_distance.begin() + ptrdiff_t(count), by_distance.end());
  std::vector<int> nearest;
  for (size_t k = 0; k < count; ++k) nearest.push_back(by_distance[k].second);
  return nearest;
}

/// ln of the distance to the third nearest other node, or to the farthest where there are fewer;
/// of a single node `alone`.
std::vector<float> log_radii(const std::vector<Vec3<float>>& nodes, float alone) {
  constexpr size_t kNeighbour = 3;
  std::vector<float> radii;
  for (const Vec3<float>& node : nodes) {
    const std::vector<int> nearest = nearest_nodes(nodes, node, kNeighbour + 1);
    const float distance2 = squared_distance(nodes[size_t(nearest.back())], node);
    radii.push_back(nodes.size() > 1 ? 0.5f * std::log(distance2) : alone);
  }
  return radii;
}

/// Moves the groups of a static set into a canonical one without bindings.
GaussianSet moved_to_canonical(GaussianSet& from) {
  GaussianSet to(SetForm::kCanonical, from.coefficients(), from.memory());
  for (int g = 0; g < kStaticGroups; ++g) to.group(Group(g)) = std::move(from.group(Group(g)));
  return to;
}

void write_zeros(Backend& backend, int64_t count, Buffer<float>& to) {
  to.resize(count);
  backend.fill_zero(to.span());
}

MotionNodes nodes_at_rest(const NodePlan& plan, int knots, int64_t step) {
  MotionNodes nodes;
  nodes.resize(int64_t(plan.position.size()), knots);
  nodes.started = nodes.refitted = step;
  for (int64_t m = 0; m < nodes.count; ++m)
    for (int c = 0; c < 3; ++c) nodes.position[3 * m + c] = plan.position[size_t(m)][c];
  std::copy(plan.log_radius.begin(), plan.log_radius.end(), nodes.log_radius.value.begin());
  std::fill(nodes.translation.value.begin(), nodes.translation.value.end(), 0.0f);
  Buffer<float>& rotation = nodes.rotation.value;
  for (int64_t i = 0; i < rotation.size(); ++i) rotation[i] = i % 4 == 0 ? 1.0f : 0.0f;
  nodes.ensure_moments();
  return nodes;
}

using Matrix = std::vector<std::vector<double>>;  // by columns

/// Column k: the weights of control point k at evenly spread times.
Matrix design(int knots) {
  constexpr int kTimes = 401;
  Matrix columns(size_t(knots), std::vector<double>(kTimes, 0.0));
  for (int i = 0; i < kTimes; ++i) {
    const SplineWeights<double> s = spline_weights(double(i) / (kTimes - 1), knots);
    for (int k = 0; k < kSplineOrder; ++k) columns[size_t(s.first + k)][size_t(i)] = s.weight[k];
  }
  return columns;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// [old knots][knots]: what each old control point gives to the new ones.
Matrix conversion(int from, int to) {
  const Matrix before = design(from), after = design(to);
  std::vector<double> normal;
  for (const std::vector<double>& a : after)
    for (const std::vector<double>& b : after) normal.push_back(dot(a, b));
  const Cholesky equations(std::move(normal), after.size());
  Matrix shares;
  for (const std::vector<double>& old : before) {
    std::vector<double> right;
    for (const std::vector<double>& a : after) right.push_back(dot(a, old));
    shares.push_back(equations.solve(std::move(right)));
  }
  return shares;
}

/// [M, old knots, width] → [M, knots, width].
void convert(const Matrix& conversion, int64_t nodes, int width, ParameterGroup& group) {
  const auto knots = int64_t(conversion[0].size()), before = int64_t(conversion.size());
  Buffer<float> old;
  old.copy_from(group.value);
  Buffer<float> controls(nodes * knots * width);
  for (int64_t m = 0; m < nodes; ++m)
    for (int64_t i = 0; i < knots; ++i)
      for (int c = 0; c < width; ++c) {
        double sum = 0;
        for (int64_t j = 0; j < before; ++j)
          sum += conversion[size_t(j)][size_t(i)] * double(old[(m * before + j) * width + c]);
        controls[(m * knots + i) * width + c] = float(sum);
      }
  group.value.copy_from(controls);
}

void zero(ParameterGroup& group) {
  Buffer<float> zeros(group.value.size());
  std::fill(zeros.begin(), zeros.end(), 0.0f);
  group.moment1.copy_from(zeros);
  group.moment2.copy_from(zeros);
}

}  // namespace

NodePlan plan_nodes(Span<const float> mean, Span<const float> opacity_logit, int64_t nodes) {
  check(mean.size == 3 * opacity_logit.size, "plan_nodes: one mean and opacity a Gaussian");
  NodePlan plan;
  const Eligible eligible = eligible_elements(mean, opacity_logit, kElementsPerNode * nodes);
  const int64_t count = std::min(nodes, int64_t(eligible.elements.size()) / kElementsPerNode);
  if (count == 0) return plan;
  plan.position = farthest_points(mean, eligible, count);
  plan.log_radius = log_radii(plan.position, std::log(std::max(eligible.reach, 1e-6f)));
  plan.node.assign(size_t(opacity_logit.size * kBindings), -1.0f);
  constexpr int64_t kGrain = 256;
  parallel_for(opacity_logit.size, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const std::vector<int> nearest =
          nearest_nodes(plan.position, load3(mean.data + 3 * n), kBindings);
      std::copy(nearest.begin(), nearest.end(), plan.node.begin() + n * kBindings);
    }
  });
  return plan;
}

void start_nodes(Backend& backend, const NodePlan& plan, int knots, TrainState& state) {
  GaussianSet& set = state.model.static_set;
  if (plan.position.empty()) return;
  const int64_t count = set.count();
  check(set.form() == SetForm::kStatic && int64_t(plan.node.size()) == count * kBindings,
        "start_nodes: a plan of another set");
  const ShBlocks blocks = set.blocks();
  const bool has_moments = set.has_moments();
  set = moved_to_canonical(set);
  Buffer<float>& node = set.group(kNode).value;
  node.resize(int64_t(plan.node.size()));
  node.memory().copy(node.data(), plan.node.data(), sizeof(float) * plan.node.size());
  ParameterGroup& logits = set.group(kNodeLogit);
  write_zeros(backend, count * kBindings, logits.value);
  if (has_moments) {
    write_zeros(backend, count * kBindings, logits.moment1);
    write_zeros(backend, count * kBindings, logits.moment2);
  }
  set.set_count(count, blocks);
  state.model.nodes = nodes_at_rest(plan, knots, state.iteration).clone_to(backend.memory(), true);
}

void refit_nodes(int knots, int64_t step, MotionNodes& nodes) {
  check(knots >= nodes.knots && !nodes.empty(), "refit_nodes: to more control points");
  const Matrix by_old = conversion(nodes.knots, knots);
  convert(by_old, nodes.count, 3, nodes.translation);
  convert(by_old, nodes.count, 4, nodes.rotation);
  for (ParameterGroup* const group : nodes.groups()) zero(*group);
  nodes.knots = knots;
  nodes.refitted = step;
}

}  // namespace tessera
