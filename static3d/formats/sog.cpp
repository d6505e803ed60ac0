// Files .sog of PlayCanvas, version 2: one zip archive of meta.json and lossless WebP images that
// have a pixel for each splat along a Morton curve. Version 1, folders of single images and
// compressed entries are not read. Source: formats 1.6 (PlayCanvas, "The SOG Format"), written from
// its layout.
#include <fmt/format.h>

#include "ingest/files/atomic_file.h"
#include "kernels/math/spherical_harmonics.h"
#include "static3d/formats/sog_archive.h"
#include "static3d/formats/sog_images.h"
#include "static3d/formats/sog_layout.h"
#include "static3d/formats/splat_formats.h"

namespace tessera {

int64_t save_sog(const std::filesystem::path& path, const GaussianSet& set,
                 const SplatDrawing& drawing) {
  const GaussianSet ordered = sog_order(path, set);
  const GaussianSpans<const float> from = ordered.values();
  std::vector<SogImage> images;
  std::string meta = fmt::format(R"({{"version":{},"asset":{{"generator":"tessera"}},"count":{},)",
                                 kSogVersion, from.count);
  if (drawing.antialiased) meta += R"("model":"antialiased",)";
  meta += add_means(from, images) + ",";
  meta += add_shapes_and_colours(from, images);
  meta += add_harmonics(from, drawing.sh_degree, images);
  write_text_file(path, sog_archive(meta + "}", images));
  return set.count() - ordered.count();
}

SplatFile load_sog(const std::filesystem::path& path) {
  check_webp(path);
  const std::string file = read_text_file(path);
  const SogArchive archive(file, path);
  if (!archive.has("version") || archive.meta()["version"] != kSogVersion)
    archive.fail("its meta.json is not of version 2");
  const int degree = degree_of(archive);
  SplatFile result;
  result.set = GaussianSet(SetForm::kStatic, sh_coefficients(degree));
  result.set.resize(archive.count());
  read_splats_of(archive, degree, result.set.values());
  result.drawing.antialiased = archive.meta().value("model", nlohmann::json()) == "antialiased";
  return result;
}

}  // namespace tessera
