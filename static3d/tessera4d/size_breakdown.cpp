// The table of components, and sums over groups and over streams.
#include "static3d/tessera4d/size_breakdown.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

struct ComponentElement {
  const char* name;
  std::vector<Group> groups;              // in memory
  std::vector<std::string_view> streams;  // of a file; docs/reference/tessera4d.md, section 4
};

/// By Component.
const std::array<ComponentElement, kComponents>& component_elements() {
  static const std::array<ComponentElement, kComponents> elements = {{
      {"means", {kMean}, {"position"}},
      {"rotations", {kRotation}, {"rotation", "rotation_largest"}},
      {"scales", {kLogScale}, {"log_scale"}},
      {"opacity", {kOpacityLogit}, {"opacity", "opacity_logit"}},
      {"colour", {kSh}, {"colour", "sh1", "sh2", "sh3"}},
      {"time",
       {kMeanTime, kLogScaleTime, kRotationRight, kShTime, kNodeLogit, kNode},
       {"velocity", "time_mean", "log_time_scale", "node", "node_weight", "node_logit",
        "node_position", "node_translation", "node_rotation", "node_log_radius"}},
  }};
  return elements;
}

template <class T, class Value>
Component element_with(std::vector<T> ComponentElement::*list, const Value& value,
                       const char* what) {
  for (int c = 0; c < kComponents; ++c) {
    const std::vector<T>& values = component_elements()[size_t(c)].*list;
    if (std::find(values.begin(), values.end(), value) != values.end()) return Component(c);
  }
  check(false, what);
  return Component::kMeans;
}

void add(ComponentBytes& to, Component component, int64_t bytes) {
  to.bytes[size_t(component)] += bytes;
}

ComponentBytes bytes_of_set(const GaussianSet& set) {
  ComponentBytes sum;
  sum.count = set.count();
  const GaussianSpans<const float> values = set.values();
  for (int g = 0; g < set.groups(); ++g)
    add(sum, component_of(Group(g)), values.group[g].size * int64_t(sizeof(float)));
  return sum;
}

ComponentBytes both(const ComponentBytes& a, const ComponentBytes& b) {
  ComponentBytes sum = a;
  sum.count += b.count;
  for (int c = 0; c < kComponents; ++c) add(sum, Component(c), b.bytes[size_t(c)]);
  return sum;
}

json set_json(const ComponentBytes& set) {
  constexpr int64_t kBits = 8;
  json bits = json::object(), each = json::object();
  const auto put = [&](const char* name, int64_t bytes) {
    bits[name] = kBits * bytes;
    if (set.count > 0) each[name] = double(kBits * bytes) / double(set.count);
  };
  for (int c = 0; c < kComponents; ++c) put(component_name(Component(c)), set.bytes[size_t(c)]);
  put("sum", set.total());
  return {{"gaussians", set.count},
          {"bits", bits},
          {"bits_per_gaussian", set.count > 0 ? each : json(nullptr)}};
}

}  // namespace

const char* component_name(Component component) {
  return component_elements()[size_t(component)].name;
}

Component component_of(Group group) {
  return element_with(&ComponentElement::groups, group, "component_of: a group of no component");
}

Component component_of_stream(std::string_view name) {
  return element_with(&ComponentElement::streams, name,
                      "component_of_stream: a stream of no component");
}

int64_t ComponentBytes::total() const {
  return std::accumulate(bytes.begin(), bytes.end(), int64_t{0});
}

int64_t SizeBreakdown::total() const {
  return fixed.total() + moving.total() + environment + container;
}

SizeBreakdown memory_breakdown(const GaussianModel& model) {
  SizeBreakdown account;
  account.fixed = bytes_of_set(model.static_set);
  account.moving = bytes_of_set(model.dynamic_set);
  account.environment = model.environment.map.value.span().size * int64_t(sizeof(float));
  return account;
}

SizeBreakdown shipped_breakdown(const Tessera4dManifest& manifest, int64_t bytes) {
  SizeBreakdown account;
  account.fixed.count = manifest.gaussians(false);
  account.moving.count = manifest.gaussians(true);
  account.container = bytes;
  for (const BlockInfo& block : manifest.blocks)
    for (const StreamInfo& stream : block.streams) {
      add(block.moving ? account.moving : account.fixed, component_of_stream(stream.name),
          int64_t(stream.bytes));
      account.container -= int64_t(stream.bytes);
    }
  return account;
}

json to_json(const SizeBreakdown& account) {
  constexpr int64_t kBits = 8;
  return {{"bytes", account.total()},
          {"container_bits", kBits * account.container},
          {"environment_bits", kBits * account.environment},
          {"static", set_json(account.fixed)},
          {"dynamic", set_json(account.moving)},
          {"all", set_json(both(account.fixed, account.moving))}};
}

ShippedSize shipped_size(const GaussianModel& model, const Tessera4dOptions& options) {
  const Tessera4dFile file = encode_tessera4d(model, options);
  ShippedSize size;
  size.bytes = int64_t(single_tessera4d(file).size());
  GaussianModel rules;
  size.account = shipped_breakdown(
      manifest_from(nlohmann::json::parse(file.manifest), "the encoded model", rules), size.bytes);
  return size;
}

}  // namespace tessera
