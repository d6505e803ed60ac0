// Rows of nodes and control points, written and read.
#include "recon4d/model/motion_nodes_file.h"

#include <fmt/format.h>

#include <cmath>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr const char* kNodeElement = "motion_node";
constexpr const char* kControlElement = "motion_control";

const std::vector<std::string>& node_columns() {
  static const std::vector<std::string> names = {"x", "y", "z", "log_radius"};
  return names;
}
const std::vector<std::string>& control_columns() {
  static const std::vector<std::string> names = {
      "translation_x", "translation_y", "translation_z", "rot_0", "rot_1", "rot_2", "rot_3"};
  return names;
}

/// [rows, columns] of an element.
std::vector<float> rows_of(const std::filesystem::path& path, const PlyFile& file, const char* name,
                           const std::vector<std::string>& columns, int64_t rows) {
  const PlyElement* const element = file.find(name);
  if (element == nullptr || element->rows != rows)
    throw InputError(
        fmt::format("{}: element '{}' does not have the {} rows of the comment motion_nodes; "
                    "export again",
                    path.string(), name, rows));
  const std::vector<float> values = read_floats(path, *element, columns);
  for (const float value : values)
    if (!std::isfinite(value))
      throw InputError(fmt::format("{}: element '{}' has a value that is not finite; export again",
                                   path.string(), name));
  return values;
}

}  // namespace

NodeElements::NodeElements(const MotionNodes& nodes) {
  for (int64_t m = 0; m < nodes.count; ++m) {
    for (int c = 0; c < 3; ++c) at_rest.push_back(nodes.position[3 * m + c]);
    at_rest.push_back(nodes.log_radius.value[m]);
  }
  for (int64_t i = 0; i < nodes.count * nodes.knots; ++i) {
    for (int c = 0; c < 3; ++c) controls.push_back(nodes.translation.value[3 * i + c]);
    for (int c = 0; c < 4; ++c) controls.push_back(nodes.rotation.value[4 * i + c]);
  }
}

std::vector<FloatElement> NodeElements::elements() const {
  const auto span = [](const std::vector<float>& values) {
    return Span<const float>{values.data(), int64_t(values.size())};
  };
  return {{kNodeElement, node_columns(), span(at_rest)},
          {kControlElement, control_columns(), span(controls)}};
}

MotionNodes read_nodes(const std::filesystem::path& path, const PlyFile& file, double count,
                       double knots) {
  const bool plausible = count >= 1 && count <= double(kMaxNodes) && count == std::floor(count) &&
                         knots >= kSplineOrder && knots <= kMaxKnots && knots == std::floor(knots);
  if (!plausible)
    throw InputError(fmt::format(
        "{}: {} motion nodes with {} control points, expected at most {} with {} to {}; "
        "export again",
        path.string(), count, knots, kMaxNodes, kSplineOrder, kMaxKnots));
  MotionNodes nodes;
  nodes.resize(int64_t(count), int(knots));
  const std::vector<float> at_rest = rows_of(path, file, kNodeElement, node_columns(), nodes.count);
  const std::vector<float> controls =
      rows_of(path, file, kControlElement, control_columns(), nodes.count * nodes.knots);
  for (int64_t m = 0; m < nodes.count; ++m) {
    for (int c = 0; c < 3; ++c) nodes.position[3 * m + c] = at_rest[size_t(4 * m + c)];
    nodes.log_radius.value[m] = at_rest[size_t(4 * m + 3)];
  }
  for (int64_t i = 0; i < nodes.count * nodes.knots; ++i) {
    for (int c = 0; c < 3; ++c) nodes.translation.value[3 * i + c] = controls[size_t(7 * i + c)];
    for (int c = 0; c < 4; ++c) nodes.rotation.value[4 * i + c] = controls[size_t(7 * i + 3 + c)];
  }
  return nodes;
}

void check_bindings(const std::filesystem::path& path, const GaussianSet& set, int64_t nodes) {
  for (const float node : set.group(kNode).value)
    if (!(node >= -1 && node < float(nodes) && node == std::floor(node)))
      throw InputError(
          fmt::format("{}: a Gaussian bound to node {}, expected -1 to {}; export again",
                      path.string(), node, nodes - 1));
}

}  // namespace tessera
