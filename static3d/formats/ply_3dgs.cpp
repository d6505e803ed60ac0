// The standard 3DGS .ply for static sets: its columns to Gaussians and back. Source: [3DGS]
// reference code's layout; formats: normals zero, f_rest channel-major.
#include "static3d/formats/splat_formats.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/splat_columns.h"

namespace tessera {
namespace {

constexpr std::array<std::string_view, 3> kColourNames = {"red", "green", "blue"};

/// Properties of `vertex` that mean nothing here.
std::vector<std::string> unknown_properties(const PlyElement& vertex, int coefficients) {
  const std::vector<SplatColumn> known = splat_columns(SetForm::kStatic, coefficients);
  std::vector<std::string> unknown;
  for (const PlyColumn& column : vertex.columns)
    if (std::none_of(known.begin(), known.end(),
                     [&](const SplatColumn& k) { return k.name == column.name; }))
      unknown.push_back(column.name);
  return unknown;
}

/// Colours of bytes in place of the first harmonics, as Nerfstudio's `ns-export gaussian-splat
/// --ply-color-mode rgb` writes them, become harmonics of degree 0. Clouds of points stay clouds.
void colours_to_harmonics(PlyElement& vertex) {
  if (vertex.find("f_dc_0") != nullptr || vertex.find("opacity") == nullptr) return;
  for (PlyColumn& column : vertex.columns) {
    const auto channel = std::find(kColourNames.begin(), kColourNames.end(), column.name);
    if (channel == kColourNames.end() || column.type != PlyType::kUint8) continue;
    column.name = fmt::format("f_dc_{}", channel - kColourNames.begin());
    for (double& value : column.values) value = (value / 255 - 0.5) / kSh0;
  }
}

GaussianSet read_plain(const std::filesystem::path& path, const PlyFile& file,
                       std::vector<std::string>& warnings) {
  const PlyElement* const vertex = file.find("vertex");
  if (vertex == nullptr)
    throw InputError(fmt::format("{}: no element 'vertex', expected a 3DGS .ply; export it again",
                                 path.string()));
  GaussianSet set = read_splats(path, *vertex, SetForm::kStatic);
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

/// By the last comment that says how the splats are drawn.
bool says_antialiased(const std::vector<std::string>& comments) {
  bool antialiased = false;
  for (const std::string& comment : comments) {
    const std::string text = lower_case(comment);
    const size_t value = text.find_last_not_of(' ') + 1;
    const std::string_view words = std::string_view(text).substr(0, value);
    if (words.starts_with("splatrendermode:")) antialiased = words.ends_with("mip");
    if (words.starts_with("antialiased ")) antialiased = words.ends_with("1");
  }
  return antialiased;
}

}  // namespace

SplatFile load_ply_splats(const std::filesystem::path& path) {
  PlyFile file = read_ply(path);
  for (PlyElement& element : file.elements)
    if (element.name == "vertex") colours_to_harmonics(element);
  SplatFile result;
  result.set = is_compressed_splat(file) ? decode_compressed_splat(path, file)
                                         : read_plain(path, file, result.warnings);
  result.drawing.antialiased = says_antialiased(file.comments);
  return result;
}

void save_ply_3dgs(const std::filesystem::path& path, const GaussianSet& set,
                   const SplatDrawing& drawing) {
  std::vector<std::string> comments;
  if (drawing.antialiased) comments.emplace_back(kAntialiasedComment);
  write_splats(path, comments, {{"vertex", &set, sh_coefficients(drawing.sh_degree)}});
}

}  // namespace tessera
