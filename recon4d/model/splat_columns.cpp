// Conversion between rows of Gaussians and PLY columns. Values are stored as they are, without
// activation or normalisation.
#include "recon4d/model/splat_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/ply_header.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

void append(std::vector<SplatColumn>& columns, Group group, std::vector<std::string> names) {
  for (size_t i = 0; i < names.size(); ++i) columns.push_back({names[i], group, int(i)});
}

void append_sh(std::vector<SplatColumn>& columns, int coefficients) {
  append(columns, kSh, {"f_dc_0", "f_dc_1", "f_dc_2"});
  const int rest = coefficients - 1;
  for (int channel = 0; channel < 3; ++channel)
    for (int k = 0; k < rest; ++k)
      columns.push_back({fmt::format("f_rest_{}", channel * rest + k), kSh, 3 * (k + 1) + channel});
}

/// Level n ≥ 1 of the colour, all K coefficients of each channel.
void append_level(std::vector<SplatColumn>& columns, int coefficients, int n) {
  for (int channel = 0; channel < 3; ++channel)
    for (int k = 0; k < coefficients; ++k)
      columns.push_back({fmt::format("f_cos{}_{}", n, channel * coefficients + k), kShTime,
                         3 * ((n - 1) * coefficients + k) + channel});
}

std::vector<SplatColumn> columns_of(const SplatElement& element) {
  if (!element.columns.empty()) return element.columns;
  return splat_columns(element.set->form(), element.coefficients, element.set->time_levels());
}

/// A file without rows: what ply_header_text needs.
PlyFile layout_of(const std::vector<std::string>& comments,
                  const std::vector<SplatElement>& elements,
                  const std::vector<FloatElement>& others) {
  PlyFile layout;
  layout.comments = comments;
  for (const SplatElement& element : elements) {
    PlyElement header{element.name, element.set->count(), {}};
    for (const SplatColumn& column : columns_of(element))
      header.columns.push_back({column.name, PlyType::kFloat32, {}});
    layout.elements.push_back(std::move(header));
  }
  for (const FloatElement& other : others) {
    PlyElement header{other.name, other.values.size / int64_t(other.columns.size()), {}};
    for (const std::string& column : other.columns)
      header.columns.push_back({column, PlyType::kFloat32, {}});
    layout.elements.push_back(std::move(header));
  }
  return layout;
}

void write_rows(AtomicFile& output, const SplatElement& element) {
  constexpr int64_t kBlockRows = 4096;
  const std::vector<SplatColumn> columns = columns_of(element);
  const GaussianSpans<const float> values = element.set->values();
  std::vector<float> block;
  for (int64_t begin = 0; begin < values.count; begin += kBlockRows) {
    block.clear();
    for (int64_t n = begin; n < std::min(begin + kBlockRows, values.count); ++n)
      for (const SplatColumn& column : columns)
        block.push_back(column.group ? values.at(*column.group, n)[column.offset] : 0.0f);
    output.write(block.data(), block.size() * sizeof(float));
  }
}

/// Levels of which there is a first property.
int stored_levels(const PlyElement& element) {
  int levels = 0;
  while (levels < kMaxTimeLevels && element.find(fmt::format("f_cos{}_0", levels + 1))) ++levels;
  return levels;
}

}  // namespace

std::vector<SplatColumn> splat_columns(SetForm form, int coefficients, int time_levels) {
  std::vector<SplatColumn> columns;
  append(columns, kMean, {"x", "y", "z"});
  if (!is_dynamic(form))
    for (const char* name : {"nx", "ny", "nz"}) columns.push_back({name, std::nullopt, 0});
  append_sh(columns, coefficients);
  append(columns, kOpacityLogit, {"opacity"});
  append(columns, kLogScale, {"scale_0", "scale_1", "scale_2"});
  append(columns, kRotation, {"rot_0", "rot_1", "rot_2", "rot_3"});
  if (form == SetForm::kCanonical)
    for (const auto& [group, name] :
         {std::pair{kNode, "node"}, std::pair{kNodeLogit, "node_logit"}})
      for (int k = 0; k < kBindings; ++k)
        columns.push_back({fmt::format("{}_{}", name, k), group, k});
  if (!is_dynamic(form)) return columns;
  append(columns, kMeanTime, {"mean_time"});
  append(columns, kLogScaleTime, {"scale_time"});
  if (form == SetForm::kPair)
    append(columns, kRotationRight, {"rot_right_0", "rot_right_1", "rot_right_2", "rot_right_3"});
  else
    append(columns, kVelocity, {"velocity_0", "velocity_1", "velocity_2"});
  for (int n = 1; n <= time_levels; ++n) append_level(columns, coefficients, n);
  return columns;
}

SetForm dynamic_form_of(const PlyElement& element) {
  return element.find("velocity_0") != nullptr ? SetForm::kVelocity : SetForm::kPair;
}

void write_splats(const std::filesystem::path& path, const std::vector<std::string>& comments,
                  const std::vector<SplatElement>& elements,
                  const std::vector<FloatElement>& others) {
  for (const SplatElement& element : elements) {
    const int stored = element.set->coefficients();
    check(!element.set->blocks().mixed(), "write_splats: rows that differ in SH degree");
    check(element.coefficients >= 1 && element.coefficients <= stored,
          "write_splats: more SH coefficients than the set stores");
    check(element.set->time_levels() == 0 || element.coefficients == stored,
          "write_splats: a part of the coefficients of a level of time");
  }
  AtomicFile output(path);
  output.write(ply_header_text(layout_of(comments, elements, others)));
  for (const SplatElement& element : elements) write_rows(output, element);
  for (const FloatElement& other : others)
    output.write(other.values.data, size_t(other.values.size) * sizeof(float));
  output.commit();
}

std::vector<float> read_floats(const std::filesystem::path& path, const PlyElement& element,
                               const std::vector<std::string>& columns) {
  std::vector<float> values(size_t(element.rows) * columns.size());
  for (size_t c = 0; c < columns.size(); ++c) {
    const PlyColumn* const column = element.find(columns[c]);
    if (column == nullptr)
      throw InputError(fmt::format("{}: element '{}' has no scalar property '{}'; export again",
                                   path.string(), element.name, columns[c]));
    for (size_t r = 0; r < size_t(element.rows); ++r)
      values[r * columns.size() + c] = float(column->values[r]);
  }
  return values;
}

int stored_coefficients(const std::filesystem::path& path, const PlyElement& element) {
  int rest = 0;
  for (const PlyColumn& column : element.columns)
    if (column.name.rfind("f_rest_", 0) == 0) ++rest;
  for (int degree = 0; degree <= kMaxShDegree; ++degree)
    if (rest == 3 * (sh_coefficients(degree) - 1)) return sh_coefficients(degree);
  throw InputError(fmt::format(
      "{}: element '{}' has {} f_rest properties, expected 0, 9, 24 or 45 (SH degree 0 to 3); "
      "export it with a whole degree",
      path.string(), element.name, rest));
}

GaussianSet read_splats(const std::filesystem::path& path, const PlyElement& element,
                        SetForm form) {
  const int coefficients = stored_coefficients(path, element);
  const int levels = is_dynamic(form) ? stored_levels(element) : 0;
  return read_columns(path, element, splat_columns(form, coefficients, levels), form, coefficients,
                      levels);
}

GaussianSet read_columns(const std::filesystem::path& path, const PlyElement& element,
                         const std::vector<SplatColumn>& columns, SetForm form, int coefficients,
                         int time_levels) {
  // All columns before any memory: a row of the file may be a byte where a Gaussian is hundreds.
  std::vector<std::pair<SplatColumn, const PlyColumn*>> found;
  for (const SplatColumn& column : columns) {
    if (!column.group) continue;
    found.emplace_back(column, element.find(column.name));
    if (found.back().second == nullptr)
      throw InputError(fmt::format(
          "{}: element '{}' has no scalar property '{}', expected a Gaussian splat .ply; export it "
          "again",
          path.string(), element.name, column.name));
  }
  GaussianSet set(form, coefficients, host_memory(), time_levels);
  set.resize(element.rows);
  const GaussianSpans<float> values = set.values();
  for (int g = 0; g < set.groups(); ++g)
    std::fill_n(values.group[g].data, values.group[g].size, 0.0f);
  for (const auto& [column, stored] : found)
    for (int64_t n = 0; n < element.rows; ++n)
      values.at(*column.group, n)[column.offset] = float(stored->values[size_t(n)]);
  return set;
}

}  // namespace tessera
