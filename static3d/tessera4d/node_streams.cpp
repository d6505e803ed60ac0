// Encoding and decoding of the weights of bindings and of the steps between control points.
#include "static3d/tessera4d/node_streams.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernels/base/errors.h"
#include "kernels/stages/carry.h"

namespace tessera {
namespace {

/// ln of a radius at which the distance from a node adds nothing to a weight.
constexpr float kEverywhere = 40;
constexpr double kWeightStep = 1.0 / 1023;
/// Largest step of control points of rotation.
constexpr double kMostRotationStep = 1.0 / 2048;

constexpr std::string_view kPosition = "node_position", kTranslation = "node_translation",
                           kRotation4 = "node_rotation", kLogRadius = "node_log_radius";

struct Weighed {
  float node = -1, weight = 0;
};

/// Nodes of Gaussian n with their weights at rest, the heaviest first.
std::array<Weighed, kBindings> weighed(const GaussianSpans<const float>& set, int64_t n,
                                       const NodeSpans<const float>& nodes) {
  Binding<float> binding;
  load_nodes(set, n, binding);
  const NodeDistances<float> d = node_distances(nodes, load3(set.at(kMean, n)), binding);
  binding_weights(set.at(kNodeLogit, n), d.falloff, d.distance2, binding);
  std::array<Weighed, kBindings> out;
  for (int k = 0; k < kBindings; ++k)
    out[size_t(k)] = {float(binding.node[k]), binding.node[k] < 0 ? -1 : binding.weight[k]};
  std::stable_sort(out.begin(), out.end(),
                   [](const Weighed& a, const Weighed& b) { return a.weight > b.weight; });
  return out;
}

/// Largest distance at rest between a node and a Gaussian that is bound to it, world units.
double reach_of(const GaussianSpans<const float>& set, const NodeSpans<const float>& nodes) {
  double most = 0;
  for (int64_t n = 0; n < set.count; ++n) {
    Binding<float> binding;
    load_nodes(set, n, binding);
    const NodeDistances<float> d = node_distances(nodes, load3(set.at(kMean, n)), binding);
    for (const float distance2 : d.distance2) most = std::max(most, double(distance2));
  }
  return std::sqrt(most);
}

/// [rows, width] → [width, rows].
std::vector<float> columns_of(Span<const float> rows, int width) {
  const int64_t count = rows.size / width;
  std::vector<float> columns(static_cast<size_t>(rows.size));
  for (int64_t i = 0; i < count; ++i)
    for (int c = 0; c < width; ++c) columns[size_t(c * count + i)] = rows[i * width + c];
  return columns;
}

void add_bindings(const GaussianSet& set, const NodeSpans<const float>& nodes, bool lossless,
                  std::vector<StreamWords>& streams) {
  const GaussianSpans<const float> values = set.values();
  if (lossless) {
    streams.push_back(quantised("node", kBindings, columns_of(values.group[kNode], kBindings), 1));
    streams.push_back(
        as_floats("node_logit", kBindings, columns_of(values.group[kNodeLogit], kBindings)));
    return;
  }
  const int64_t count = set.count();
  std::vector<float> node(static_cast<size_t>(kBindings * count)),
      weight(static_cast<size_t>((kBindings - 1) * count));
  for (int64_t n = 0; n < count; ++n) {
    const std::array<Weighed, kBindings> all = weighed(values, n, nodes);
    for (int k = 0; k < kBindings; ++k) {
      const float w = all[size_t(k)].weight;
      const bool counts = w > 0.5 * kWeightStep;
      node[size_t(k * count + n)] = counts ? all[size_t(k)].node : -1;
      if (k > 0) weight[size_t((k - 1) * count + n)] = counts ? w : 0;
    }
  }
  streams.push_back(quantised("node", kBindings, node, 1));
  streams.push_back(quantised("node_weight", kBindings - 1, weight, kWeightStep));
}

}  // namespace

bool is_bound(const GaussianSpans<const float>& set, int64_t n) {
  Binding<float> binding;
  return load_nodes(set, n, binding);
}

int64_t node_rows(std::string_view name, int64_t nodes, int knots) {
  if (name == kPosition || name == kLogRadius) return nodes;
  return name == kTranslation || name == kRotation4 ? nodes * knots : 0;
}

std::vector<StreamWords> node_streams(const GaussianSet& set, const MotionNodes& nodes, double step,
                                      bool lossless) {
  const NodeSpans<const float> spans = nodes.spans();
  std::vector<StreamWords> streams;
  add_bindings(set, spans, lossless, streams);
  const auto add = [&](std::string_view name, int width, Span<const float> rows, double at_most) {
    const std::vector<float> columns = columns_of(rows, width);
    streams.push_back(lossless ? as_floats(std::string(name), width, columns)
                               : quantised(std::string(name), width, columns, at_most));
  };
  add(kPosition, 3, spans.position, step);
  add(kTranslation, 3, spans.translation, step);
  // a point turns by at most twice the error of a unit quaternion
  add(kRotation4, 4, spans.rotation,
      std::min(kMostRotationStep, step / std::max(2 * reach_of(set.values(), spans), 1e-6)));
  if (lossless) add(kLogRadius, 1, spans.log_radius, step);
  return streams;
}

void read_bindings(const StreamWords& node, const StreamWords& weight, int64_t nodes,
                   const GaussianSpans<float>& to, const std::filesystem::path& path) {
  const bool has_logits = weight.info.name == "node_logit";
  for (int64_t n = 0; n < to.count; ++n) {
    std::fill_n(to.at(kNode, n), kBindings, -1.0f);
    std::fill_n(to.at(kNodeLogit, n), kBindings, 0.0f);
    float left = 1;  // of the first node
    for (int k = 0; !has_logits && k < weight.info.components; ++k) left -= value_at(weight, k, n);
    for (int k = 0; k < node.info.components; ++k) {
      const float id = value_at(node, k, n);
      if (!(id >= -1 && id < float(nodes)) || id != std::floor(id))
        throw InputError(fmt::format("{}: a Gaussian is bound to node {} of {}; export it again",
                                     path.string(), id, nodes));
      if (has_logits) {
        to.at(kNode, n)[k] = id;
        to.at(kNodeLogit, n)[k] = value_at(weight, k, n);
        continue;
      }
      const float share = k == 0 ? left : value_at(weight, k - 1, n);
      if (!(share > 0)) continue;
      to.at(kNode, n)[k] = id;
      to.at(kNodeLogit, n)[k] = std::log(share);
    }
  }
}

MotionNodes nodes_from(const NodeStreams& streams, int64_t count, int knots,
                       const std::filesystem::path& path) {
  MotionNodes nodes;
  nodes.resize(count, knots);
  const auto fill = [&](const StreamWords& stream, Span<float> rows) {
    const int width = stream.info.components;
    for (int64_t i = 0; i < stream.info.count; ++i)
      for (int c = 0; c < width; ++c) {
        rows[i * width + c] = value_at(stream, c, i);
        if (!std::isfinite(rows[i * width + c]))
          throw InputError(
              fmt::format("{}: stream '{}' has a value that is not finite; export it "
                          "again",
                          path.string(), stream.info.name));
      }
  };
  const NodeSpans<float> to = nodes.spans();
  fill(streams.position, to.position);
  fill(streams.translation, to.translation);
  fill(streams.rotation, to.rotation);
  if (streams.log_radius != nullptr)
    fill(*streams.log_radius, to.log_radius);
  else
    std::fill_n(to.log_radius.data, to.log_radius.size, kEverywhere);
  return nodes;
}

}  // namespace tessera
