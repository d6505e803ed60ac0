// Writes .sog of PlayCanvas, version 2: a zip archive of meta.json and lossless WebP images that
// have a pixel for each splat along a Morton curve. Source: formats 1.6 (PlayCanvas, "The SOG
// Format"), written from its layout.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "ingest/files/stored_zip.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/lossless_webp.h"
#include "static3d/formats/sog_layout.h"
#include "static3d/formats/splat_formats.h"
#include "static3d/transform/far_gaussians.h"
#include "static3d/transform/scalar_codebook.h"
#include "static3d/transform/scene_box.h"
#include "static3d/transform/vector_palette.h"

namespace tessera {
namespace {

struct SogImage {
  std::string name;
  RgbaImage image;
};

struct SogRange {
  std::array<float, 3> low{}, high{};  // of the logarithms of means
};

/// As square as whole blocks of 4 x 4 pixels allow; opaque.
RgbaImage sog_image(int64_t count) {
  const int width = std::max(4, int(std::ceil(std::sqrt(double(count)) / 4)) * 4);
  const int64_t rows = (count + width - 1) / width;
  RgbaImage image(width, std::max(4, int(rows + 3) / 4 * 4));
  for (int64_t i = 0; i < image.pixels(); ++i) image.at(i, 3) = 255;
  return image;
}

SogRange range_of_means(const GaussianSpans<const float>& from) {
  SogRange range;
  if (from.count == 0) return range;
  for (int k = 0; k < 3; ++k) {
    float low = INFINITY, high = -INFINITY;
    for (int64_t n = 0; n < from.count; ++n) {
      low = std::min(low, from.at(kMean, n)[k]);
      high = std::max(high, from.at(kMean, n)[k]);
    }
    range.low[size_t(k)] = float(sog_logarithm(double(low)));
    range.high[size_t(k)] = float(sog_logarithm(double(high)));
  }
  return range;
}

/// Whether the range of logarithms up to a mean leaves the core of the scene within 1/256 of its
/// half extent.
bool is_in_range(const SceneBox& box, const float* mean) {
  constexpr double kShare = 1.0 / 256;
  const double h = double(box.half_extent);
  for (int k = 0; k < 3; ++k) {
    const double centre = double(box.centre[k]);
    const double most = 2 * kSogSteps * kShare * h / (1 + std::abs(centre) + h);  // range
    if (std::abs(sog_logarithm(double(mean[k])) - sog_logarithm(centre)) > most / 2) return false;
  }
  return true;
}

void add_means(std::vector<SogImage>& images, const GaussianSpans<const float>& from,
               const SogRange& range) {
  RgbaImage low = sog_image(from.count), high = low;
  for (int64_t n = 0; n < from.count; ++n)
    for (int k = 0; k < 3; ++k) {
      const double a = double(range.low[size_t(k)]), b = double(range.high[size_t(k)]);
      const double t = b > a ? (sog_logarithm(double(from.at(kMean, n)[k])) - a) / (b - a) : 0;
      const uint32_t step = bits_of(t, 16);
      low.at(n, k) = uint8_t(step & 255);
      high.at(n, k) = uint8_t(step >> 8);
    }
  images.push_back({"means_l.webp", std::move(low)});
  images.push_back({"means_u.webp", std::move(high)});
}

void add_rotations(std::vector<SogImage>& images, const GaussianSpans<const float>& from) {
  RgbaImage image = sog_image(from.count);
  for (int64_t n = 0; n < from.count; ++n) {
    const std::array<uint8_t, 4> bytes = sog_quaternion(from.at(kRotation, n));
    for (int k = 0; k < 4; ++k) image.at(n, k) = bytes[size_t(k)];
  }
  images.push_back({"quats.webp", std::move(image)});
}

/// The first three numbers of a group of each splat, by a codebook that they share.
ScalarCodebook add_indices(std::vector<SogImage>& images, const char* name,
                           const GaussianSpans<const float>& from, Group group) {
  std::vector<float> values;
  for (int64_t n = 0; n < from.count; ++n)
    values.insert(values.end(), from.at(group, n), from.at(group, n) + 3);
  const ScalarCodebook codebook(values);
  RgbaImage image = sog_image(from.count);
  for (int64_t n = 0; n < from.count; ++n)
    for (int k = 0; k < 3; ++k) image.at(n, k) = codebook.nearest(values[size_t(3 * n + k)]);
  images.push_back({name, std::move(image)});
  return codebook;
}

/// The largest power of two that is not above the number of splats, as the format's own writer.
int64_t palette_size(int64_t count) {
  int64_t size = 1;
  while (2 * size <= std::min(count, kSogMostEntries)) size *= 2;
  return size;
}

/// The member of meta.json of coefficients from the first degree on.
std::string add_harmonics(std::vector<SogImage>& images, const GaussianSpans<const float>& from,
                          int sh_degree) {
  const int rest = sh_coefficients(sh_degree) - 1;
  std::vector<float> vectors;
  for (int64_t n = 0; n < from.count; ++n)
    vectors.insert(vectors.end(), from.at(kSh, n) + 3, from.at(kSh, n) + 3 + 3 * rest);
  const VectorPalette palette = vector_palette(vectors, 3 * rest, palette_size(from.count));
  const ScalarCodebook codebook(palette.entries);
  RgbaImage entries(kSogEntriesPerRow * rest,
                    int((palette.count() + kSogEntriesPerRow - 1) / kSogEntriesPerRow));
  for (int64_t i = 0; i < entries.pixels(); ++i) entries.at(i, 3) = 255;
  for (size_t i = 0; i < palette.entries.size(); ++i)
    entries.at(int64_t(i / 3), int(i % 3)) = codebook.nearest(palette.entries[i]);
  RgbaImage labels = sog_image(from.count);
  for (int64_t n = 0; n < from.count; ++n) {
    labels.at(n, 0) = uint8_t(palette.labels[size_t(n)] & 255);
    labels.at(n, 1) = uint8_t(palette.labels[size_t(n)] >> 8);
  }
  images.push_back({"shN_centroids.webp", std::move(entries)});
  images.push_back({"shN_labels.webp", std::move(labels)});
  return fmt::format(R"(,"shN":{{"count":{},"bands":{},"codebook":[{}],)"
                     R"("files":["shN_centroids.webp","shN_labels.webp"]}})",
                     palette.count(), sh_degree, fmt::join(codebook.entries(), ","));
}

std::string zipped(std::string meta, const std::vector<SogImage>& images) {
  std::vector<ZipEntry> entries{{kSogMeta, std::move(meta)}};
  for (const SogImage& image : images) entries.push_back({image.name, ""});
  parallel_for(int64_t(images.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i)
      entries[size_t(i) + 1].bytes = encode_lossless_webp(images[size_t(i)].image);
  });
  return stored_zip(entries);
}

}  // namespace

int64_t save_sog(const std::filesystem::path& path, const GaussianSet& set, int sh_degree) {
  constexpr int64_t kMostSplats = int64_t{kMostWebpSide - 3} * (kMostWebpSide - 3);
  check_webp(path);
  if (set.count() > kMostSplats)
    throw InputError(fmt::format("{}: .sog holds {} Gaussians, there are {}; export as ply",
                                 path.string(), kMostSplats, set.count()));
  const FarShells shells(set.values());
  const HeldRows held = rows_within(
      set.values(), shells, [&](const float* mean) { return is_in_range(shells.box(), mean); });
  const GaussianSet sound = select_elements(set, held.rows);
  const GaussianSet ordered = select_elements(sound, morton_order(sound.values()));
  const GaussianSpans<const float> from = ordered.values();
  const SogRange range = range_of_means(from);
  std::vector<SogImage> images;
  add_means(images, from, range);
  add_rotations(images, from);
  const ScalarCodebook scales = add_indices(images, "scales.webp", from, kLogScale);
  const ScalarCodebook colours = add_indices(images, "sh0.webp", from, kSh);
  for (int64_t n = 0; n < from.count; ++n)
    images.back().image.at(n, 3) = opacity_byte(*from.at(kOpacityLogit, n));
  std::string meta =
      fmt::format(R"({{"version":{},"asset":{{"generator":"tessera"}},"count":{},)"
                  R"("means":{{"mins":[{}],"maxs":[{}],"files":["means_l.webp","means_u.webp"]}},)"
                  R"("scales":{{"codebook":[{}],"files":["scales.webp"]}},)"
                  R"("quats":{{"files":["quats.webp"]}},)"
                  R"("sh0":{{"codebook":[{}],"files":["sh0.webp"]}})",
                  kSogVersion, from.count, fmt::join(range.low, ","), fmt::join(range.high, ","),
                  fmt::join(scales.entries(), ","), fmt::join(colours.entries(), ","));
  if (sh_degree > 0 && from.count > 0) meta += add_harmonics(images, from, sh_degree);
  write_text_file(path, zipped(meta + "}", images));
  return int64_t(held.beyond.size());
}

}  // namespace tessera
