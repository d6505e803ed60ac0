// The table of formats, the detection of a file's format, and the checks that all formats share.
#include "static3d/formats/splat_file.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <utility>

#include "ingest/files/stored_zip.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/options/nearest_name.h"
#include "static3d/formats/splat_formats.h"

namespace tessera {
namespace {

/// Unit to the rounding of floats: such quaternions stay as they are, so that a file that was
/// written, read and written again has the same bytes.
constexpr double kUnitTolerance = 1e-6;

void drop_invalid(const std::filesystem::path& path, SplatFile& file) {
  const std::vector<int64_t> rows = valid_elements(file.set);
  if (int64_t(rows.size()) == file.set.count()) return;
  file.warnings.push_back(
      fmt::format("{}: {} of {} Gaussians dropped: a value not finite, or a quaternion of length 0",
                  path.string(), file.set.count() - int64_t(rows.size()), file.set.count()));
  file.set = select_elements(file.set, rows);
}

std::string head_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string head(8, '\0');
  stream.read(head.data(), std::streamsize(head.size()));
  head.resize(size_t(stream.gcount()));
  return head;
}

/// Whether quaternions of the format are of length 1 but for its quantum.
struct Reader {
  SplatFile (*load)(const std::filesystem::path&);
  bool quantised;
};

Reader reader_of(const std::filesystem::path& path, std::string_view head) {
  if (head.starts_with("ply")) return {load_ply_splats, false};
  if (is_spz(head)) return {load_spz, true};
  if (is_zip(head)) return {load_sog, true};
  if (is_glb(head)) return {load_glb, true};
  if (lower_case(path.extension().string()) == ".splat") return {load_splat_rows, true};
  return {nullptr, false};
}

}  // namespace

const std::vector<SplatFormat>& splat_formats() {
  static const std::vector<SplatFormat> rows = {
      {"ply", ".ply", "3DGS, exact; every program",
       [](const std::filesystem::path& path, const GaussianSet& set, const SplatDrawing& drawing) {
         save_ply_3dgs(path, set, drawing);
         return int64_t{0};
       }},
      {"compressed", ".compressed.ply", "a quarter of ply; SuperSplat, PlayCanvas, Spark",
       save_compressed_splat},
      {"spz", ".spz", "a tenth of ply; Spark, three.js, Unity",
       [](const std::filesystem::path& path, const GaussianSet& set, const SplatDrawing& drawing) {
         return save_spz(path, set, drawing);
       }},
      {"sog", ".sog", "an eighth of ply; SuperSplat, PlayCanvas, Spark", save_sog},
      {"splat", ".splat", "no view-dependent colour; older viewers",
       [](const std::filesystem::path& path, const GaussianSet& set, const SplatDrawing&) {
         save_splat_rows(path, set);
         return int64_t{0};
       },
       false},
      {"glb", ".glb", "glTF with KHR_gaussian_splatting, floats; three.js, Babylon",
       [](const std::filesystem::path& path, const GaussianSet& set, const SplatDrawing& drawing) {
         save_glb(path, set, drawing.sh_degree);
         return int64_t{0};
       },
       false},
  };
  return rows;
}

const SplatFormat& splat_format(const std::string& name) {
  std::vector<std::string> names;
  for (const SplatFormat& format : splat_formats()) {
    if (name == format.name) return format;
    names.push_back(format.name);
  }
  throw InputError(fmt::format("unknown format '{}'{}", name, known_names(name, names)));
}

SplatFormat spz_format(int version) {
  if (version != 3 && version != 4)
    throw InputError(
        fmt::format("--spz-version is {}, there are 3 and 4; pass one of them", version));
  SplatFormat format = splat_format("spz");
  if (version == 4)
    format.save = [](const std::filesystem::path& path, const GaussianSet& set,
                     const SplatDrawing& drawing) { return save_spz(path, set, drawing, 4); };
  return format;
}

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

bool is_splat_file(const std::filesystem::path& path, std::string_view head) {
  return reader_of(path, head).load != nullptr;
}

SplatFile load_splat_file(const std::filesystem::path& path) {
  const Reader reader = reader_of(path, head_of(path));
  if (reader.load == nullptr)
    throw InputError(
        fmt::format("{}: no splats; expected a .ply, .spz, .sog, .splat or .glb (splat-transform "
                    "converts .ksplat)",
                    path.string()));
  SplatFile file = reader.load(path);
  drop_invalid(path, file);
  const int64_t changed = normalise_rotations(file.set);
  if (changed > 0 && !reader.quantised)
    file.warnings.push_back(
        fmt::format("{}: {} quaternions were not of length 1, normalised", path.string(), changed));
  file.drawing.sh_degree = sh_degree_of(file.set.coefficients());
  return file;
}

int64_t save_splat_file(const SplatFormat& format, const std::filesystem::path& path,
                        const GaussianSet& set, const SplatDrawing& drawing) {
  check(set.dim() == 3, "save_splat_file: a static set; slice a dynamic one first");
  const std::vector<int64_t> rows = valid_elements(set);
  GaussianSet sound = select_elements(set, rows);
  normalise_rotations(sound);
  SplatDrawing held = drawing;
  held.sh_degree = std::min(drawing.sh_degree, sh_degree_of(sound.coefficients()));
  const int64_t far = format.save(path, sound, held);
  return set.count() - int64_t(rows.size()) + far;
}

GaussianModel model_of(SplatFile file) {
  GaussianModel model;
  model.static_set = std::move(file.set);
  model.drawing.sh_degree = file.drawing.sh_degree;
  model.drawing.filter_2d = file.drawing.antialiased;
  return model;
}

}  // namespace tessera
