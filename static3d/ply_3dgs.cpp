// What: other people's rows → sound Gaussians with unit quaternions, and back.
// Not: the columns (recon4d/splat_columns.h).
#include "static3d/ply_3dgs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/math/splat.h"
#include "recon4d/hygiene.h"
#include "recon4d/splat_columns.h"
#include "static3d/ply_compressed.h"

namespace tessera {
namespace {

/// Unit to the rounding of floats: such quaternions stay as they are, so that a file that was
/// written, read and written again has the same bytes.
constexpr double kUnitTolerance = 1e-6;

/// Returns how many quaternions were not of length 1.
int64_t normalise_rotations(GaussianSet& set) {
  const GaussianSpans<float> values = set.values();
  int64_t changed = 0;
  for (int64_t n = 0; n < set.count(); ++n) {
    float* const q = values.at(kRotation, n);
    const double norm = std::sqrt(double(q[0]) * q[0] + double(q[1]) * q[1] + double(q[2]) * q[2] +
                                  double(q[3]) * q[3]);
    if (std::abs(norm - 1) <= kUnitTolerance) continue;
    for (int k = 0; k < 4; ++k) q[k] = float(q[k] / norm);
    ++changed;
  }
  return changed;
}

/// Properties of `vertex` that mean nothing here.
std::vector<std::string> unknown_properties(const PlyElement& vertex, int coefficients) {
  const std::vector<SplatColumn> known = splat_columns(Form::kStatic, coefficients);
  std::vector<std::string> unknown;
  for (const PlyColumn& column : vertex.columns)
    if (std::none_of(known.begin(), known.end(),
                     [&](const SplatColumn& k) { return k.name == column.name; }))
      unknown.push_back(column.name);
  return unknown;
}

GaussianSet read_plain(const std::filesystem::path& path, const PlyFile& file,
                       std::vector<std::string>& warnings) {
  const PlyElement* const vertex = file.find("vertex");
  if (vertex == nullptr)
    throw InputError(fmt::format("{}: no element 'vertex', expected a 3DGS .ply; export it again",
                                 path.string()));
  GaussianSet set = read_splats(path, *vertex, Form::kStatic);
  const auto unknown = unknown_properties(*vertex, set.coefficients());
  if (!unknown.empty())
    warnings.push_back(
        fmt::format("{}: unknown properties ignored: {}", path.string(), fmt::join(unknown, ", ")));
  for (const PlyElement& element : file.elements)
    if (element.name != "vertex")
      warnings.push_back(fmt::format("{}: element '{}' ignored ({} rows)", path.string(),
                                     element.name, element.rows));
  return set;
}

}  // namespace

Ply3dgs load_ply_3dgs(const std::filesystem::path& path) {
  const PlyFile file = read_ply(path);
  Ply3dgs result;
  GaussianSet set = is_compressed_splat(file) ? decode_compressed_splat(path, file)
                                              : read_plain(path, file, result.warnings);
  const std::vector<int64_t> rows = sound_rows(set);
  if (int64_t(rows.size()) < set.count()) {
    result.warnings.push_back(fmt::format(
        "{}: {} of {} Gaussians dropped: a value not finite, or a quaternion of length 0",
        path.string(), set.count() - int64_t(rows.size()), set.count()));
    set = select_rows(set, rows);
  }
  if (const int64_t changed = normalise_rotations(set))
    result.warnings.push_back(
        fmt::format("{}: {} quaternions were not of length 1, normalised", path.string(), changed));
  result.sh_degree = sh_degree_of(set.coefficients());
  result.set = std::move(set);
  return result;
}

int64_t save_ply_3dgs(const std::filesystem::path& path, const GaussianSet& set, int sh_degree) {
  check(set.dim() == 3, "save_ply_3dgs: a static set; slice a dynamic one first");
  const std::vector<int64_t> rows = sound_rows(set);
  GaussianSet sound = select_rows(set, rows);
  normalise_rotations(sound);
  const int coefficients = std::min(sh_coefficients(sh_degree), set.coefficients());
  write_splats(path, {}, {{"vertex", &sound, coefficients}});
  return set.count() - int64_t(rows.size());
}

}  // namespace tessera
