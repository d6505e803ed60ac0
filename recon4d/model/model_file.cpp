// Comments and elements of the Tessera .ply, including motion nodes. The columns of Gaussians are
// in splat_columns.h.
#include "recon4d/model/model_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <type_traits>

#include "ingest/files/ply_header.h"
#include "kernels/base/errors.h"
#include "kernels/math/environment.h"
#include "recon4d/model/splat_columns.h"

namespace tessera {
namespace {

constexpr int kFormatVersion = 2, kNodesVersion = 3;  // the second of models with motion nodes
constexpr const char* kNodesKey = "motion_nodes";
constexpr const char* kVersionKey = "tessera_4d_version";
constexpr const char* kStaticElement = "vertex";
constexpr const char* kDynamicElement = "vertex_dynamic";
constexpr const char* kEnvironmentElement = "environment";

std::vector<std::string> environment_columns() {
  return {"red", "green", "blue"};
}

/// Of a comment that every file has.
std::vector<double> numbers_of(const std::filesystem::path& path,
                               const std::vector<std::string>& comments, const std::string& key,
                               size_t count) {
  std::vector<double> numbers = comment_numbers(path, comments, key, count);
  if (!numbers.empty()) return numbers;
  throw InputError(fmt::format(
      "{}: no comment '{}', expected a Tessera 4D .ply; a 3DGS .ply is read as a static model",
      path.string(), key));
}

/// How it is to be drawn.
void read_rules(const std::filesystem::path& path, const std::vector<std::string>& comments,
                DrawingRules& rules) {
  for_each_rule(rules, [&](const char* name, auto& rule) {
    using Rule = std::remove_reference_t<decltype(rule)>;
    const double number = numbers_of(path, comments, name, 1)[0];
    const double most = double(std::numeric_limits<Rule>::max());
    if (std::is_integral_v<Rule> &&
        !(number >= 0 && number <= most && number == std::floor(number)))
      throw InputError(fmt::format("{}: {} is {}, expected a whole number; export again",
                                   path.string(), name, number));
    rule = Rule(number);
  });
  if (const std::string wrong = wrong_rule(rules); !wrong.empty())
    throw InputError(fmt::format("{}: {}; export again", path.string(), wrong));
}

void read_comments(const std::filesystem::path& path, const std::vector<std::string>& comments,
                   GaussianModel& model) {
  const double version = numbers_of(path, comments, kVersionKey, 1)[0];
  if (version != kFormatVersion && version != kNodesVersion)
    throw InputError(
        fmt::format("{}: format version {}, this program reads {} and {}; use the program "
                    "that wrote it or export again",
                    path.string(), version, kFormatVersion, kNodesVersion));
  const bool has_nodes = !comment_numbers(path, comments, kNodesKey, 2).empty();
  if (has_nodes != (version == kNodesVersion))
    throw InputError(fmt::format("{}: format version {} {} motion nodes; export again",
                                 path.string(), version, has_nodes ? "with" : "without"));
  const auto axis = numbers_of(path, comments, "time_axis", 2);
  if (!(axis[1] > 0))
    throw InputError(fmt::format("{}: a clip of {} seconds, expected more than 0; export again",
                                 path.string(), axis[1]));
  model.time_axis = {axis[0], axis[1]};
  const auto background = numbers_of(path, comments, "background", 3);
  for (size_t c = 0; c < 3; ++c) {
    if (!(background[c] >= 0 && background[c] <= 255))
      throw InputError(fmt::format("{}: background {}, expected 0 to 255; export again",
                                   path.string(), background[c]));
    model.background[c] = uint8_t(background[c]);
  }
  const double scale = numbers_of(path, comments, "train_scale", 1)[0];
  if (!(scale > 0))
    throw InputError(fmt::format("{}: train_scale {}, expected a number above 0; export again",
                                 path.string(), scale));
  model.train_scale = scale;
  read_rules(path, comments, model.drawing);
  const auto world = numbers_of(path, comments, "prepared_from_source", kSimilarityNumbers);
  if (!(world[0] > 0))
    throw InputError(fmt::format("{}: a world of scale {}, expected a number above 0; export again",
                                 path.string(), world[0]));
  SimilarityNumbers numbers{};
  std::copy(world.begin(), world.end(), numbers.begin());
  model.prepared_from_source = similarity_from_numbers(numbers);
}

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

EnvironmentLight read_environment(const std::filesystem::path& path, const PlyFile& file) {
  EnvironmentLight environment;
  const auto numbers =
      comment_numbers(path, file.comments, kEnvironmentElement, 1 + kSimilarityNumbers);
  if (numbers.empty()) return environment;
  const PlyElement* const element = file.find(kEnvironmentElement);
  const bool plausible = numbers[0] >= 1 && numbers[0] <= 1 << 16;
  environment.height = plausible ? int(numbers[0]) : 0;
  const int64_t scalars = environment_scalars(environment.height);
  if (!plausible || element == nullptr || 3 * element->rows != scalars)
    throw InputError(
        fmt::format("{}: element '{}' does not have the {} rows of its comment's map; "
                    "export again",
                    path.string(), kEnvironmentElement, scalars / 3));
  SimilarityNumbers turn{};
  std::copy(numbers.begin() + 1, numbers.end(), turn.begin());
  environment.map_from_world = similarity_from_numbers(turn).rotation;
  const std::vector<float> texels = read_floats(path, *element, environment_columns());
  environment.map.value.resize(scalars);
  std::copy(texels.begin(), texels.end(), environment.map.value.begin());
  return environment;
}

}  // namespace

void save_model(const std::filesystem::path& path, const GaussianModel& model) {
  const auto& rgb = model.background;
  std::vector<std::string> comments = {
      fmt::format("{} {}", kVersionKey, model.nodes.empty() ? kFormatVersion : kNodesVersion),
      fmt::format("time_axis {} {}", model.time_axis.origin, model.time_axis.duration),
      fmt::format("background {} {} {}", rgb[0], rgb[1], rgb[2]),
      fmt::format("train_scale {}", model.train_scale),
      fmt::format("prepared_from_source {}",
                  fmt::join(similarity_numbers(model.prepared_from_source), " "))};
  for_each_rule(model.drawing, [&](const char* name, auto rule) {
    comments.push_back(fmt::format("{} {}", name, double(rule)));
  });
  // A model without movement is a file that any viewer of static splats opens.
  std::vector<SplatElement> elements = {
      {kStaticElement, &model.static_set, model.static_set.coefficients()}};
  if (model.dynamic_set.count() > 0)
    elements.push_back({kDynamicElement, &model.dynamic_set, model.dynamic_set.coefficients()});
  std::vector<FloatElement> others;
  const EnvironmentLight& environment = model.environment;
  if (environment.height > 0) {
    const Similarity turn{1, environment.map_from_world, {}};
    comments.push_back(fmt::format("environment {} {}", environment.height,
                                   fmt::join(similarity_numbers(turn), " ")));
    others.push_back({kEnvironmentElement, environment_columns(), environment.map.value.span()});
  }
  const NodeElements nodes(model.nodes);
  if (!model.nodes.empty()) {
    comments.push_back(fmt::format("{} {} {}", kNodesKey, model.nodes.count, model.nodes.knots));
    for (FloatElement& element : nodes.elements()) others.push_back(std::move(element));
  }
  write_splats(path, comments, elements, others);
}

GaussianModel load_model(const std::filesystem::path& path) {
  const PlyFile file = read_ply(path);
  GaussianModel model;
  read_comments(path, file.comments, model);
  model.environment = read_environment(path, file);
  const PlyElement* const static_element = file.find(kStaticElement);
  if (static_element == nullptr)
    throw InputError(fmt::format("{}: no element '{}', expected a Tessera 4D .ply; export again",
                                 path.string(), kStaticElement));
  const auto counts = comment_numbers(path, file.comments, kNodesKey, 2);
  if (!counts.empty()) model.nodes = read_nodes(path, file, counts[0], counts[1]);
  model.static_set = read_splats(path, *static_element,
                                 model.nodes.empty() ? SetForm::kStatic : SetForm::kCanonical);
  if (!model.nodes.empty()) check_bindings(path, model.static_set, model.nodes.count);
  if (const PlyElement* const dynamic_element = file.find(kDynamicElement))
    model.dynamic_set = read_splats(path, *dynamic_element, dynamic_form_of(*dynamic_element));
  return model;
}

bool is_tessera_model(const std::filesystem::path& path) {
  constexpr size_t kHeaderBytes = 1 << 14;  // the comments come first
  std::FILE* const file = std::fopen(path.c_str(), "rb");
  if (file == nullptr)
    throw InputError(
        fmt::format("{}: cannot be read; check the path and its permissions", path.string()));
  std::string head(kHeaderBytes, '\0');
  head.resize(std::fread(head.data(), 1, head.size(), file));
  std::fclose(file);
  const std::string_view header = std::string_view(head).substr(0, head.find("\nend_header"));
  return header.rfind("ply", 0) == 0 &&
         header.find(fmt::format("\ncomment {} ", kVersionKey)) != std::string_view::npos;
}

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
