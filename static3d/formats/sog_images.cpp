// Codebooks and a palette are made anew for each file, without random numbers.
#include "static3d/formats/sog_images.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ingest/files/stored_zip.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/sog_layout.h"
#include "static3d/transform/far_gaussians.h"
#include "static3d/transform/scene_box.h"
#include "static3d/transform/vector_palette.h"

namespace tessera {
namespace {

/// The largest power of two that is not above the number of splats, as the format's own writer.
int64_t palette_size(int64_t count) {
  int64_t size = 1;
  while (2 * size <= std::min(count, kSogMostEntries)) size *= 2;
  return size;
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

}  // namespace

RgbaImage sog_image(int64_t count) {
  const int width = std::max(4, int(std::ceil(std::sqrt(double(count)) / 4)) * 4);
  const int64_t rows = (count + width - 1) / width;
  RgbaImage image(width, std::max(4, int(rows + 3) / 4 * 4));
  for (int64_t i = 0; i < image.pixels(); ++i) image.at(i, 3) = 255;
  return image;
}

SogRange::SogRange(int64_t count, int channels, const SogValue& value)
    : low(size_t(channels), 0.0f), high(size_t(channels), 0.0f) {
  if (count == 0) return;
  for (int k = 0; k < channels; ++k) {
    double least = INFINITY, most = -INFINITY;
    for (int64_t n = 0; n < count; ++n) {
      least = std::min(least, value(n, k));
      most = std::max(most, value(n, k));
    }
    low[size_t(k)] = float(least);
    high[size_t(k)] = float(most);
  }
}

SogRange SogRange::about_zero() const {
  constexpr int kBelow = kSogSteps / 2, kAbove = kSogSteps - kBelow;  // steps, of 15 and 16 bits
  SogRange centred = *this;
  for (size_t k = 0; k < low.size(); ++k) {
    const double most = std::max(std::abs(double(low[k])), std::abs(double(high[k])));
    int exponent = 0;
    std::frexp(most / kAbove, &exponent);
    const double unit =
        std::ldexp(1.0, exponent - 8);  // a step of 8 bits, so that floats are exact
    const double step = std::ceil(most / kAbove / unit) * unit;
    centred.low[k] = float(-kBelow * step);
    centred.high[k] = float(kAbove * step);
  }
  return centred;
}

std::string numbers_text(const float* values, size_t count) {
  return fmt::format("{}", fmt::join(values, values + count, ","));
}

std::string SogRange::text() const {
  return fmt::format(R"("mins":[{}],"maxs":[{}])", numbers_text(low.data(), low.size()),
                     numbers_text(high.data(), high.size()));
}

std::string add_planes(const std::string& name, int64_t count, const SogRange& range,
                       const SogValue& value, std::vector<SogImage>& images) {
  RgbaImage low = sog_image(count), high = low;
  for (int64_t n = 0; n < count; ++n)
    for (size_t k = 0; k < range.low.size(); ++k) {
      const double a = double(range.low[k]), b = double(range.high[k]);
      const uint32_t step = bits_of(b > a ? (value(n, int(k)) - a) / (b - a) : 0, 16);
      low.at(n, int(k)) = uint8_t(step & 255);
      high.at(n, int(k)) = uint8_t(step >> 8);
    }
  images.push_back({name + "_l.webp", std::move(low)});
  images.push_back({name + "_u.webp", std::move(high)});
  return fmt::format(R"("files":["{0}_l.webp","{0}_u.webp"])", name);
}

GaussianSet sog_order(const std::filesystem::path& path, const GaussianSet& set) {
  constexpr int64_t kMostSplats = int64_t{kMostWebpSide - 3} * (kMostWebpSide - 3);
  check_webp(path);
  if (set.count() > kMostSplats)
    throw InputError(fmt::format("{}: its images hold {} Gaussians, there are {}; export as ply",
                                 path.string(), kMostSplats, set.count()));
  const FarShells shells(set.values());
  const HeldRows held = rows_within(
      set.values(), shells, [&](const float* mean) { return is_in_range(shells.box(), mean); });
  const GaussianSet sound = select_elements(set, held.rows);
  return select_elements(sound, morton_order(sound.values()));
}

std::string add_means(const GaussianSpans<const float>& from, std::vector<SogImage>& images) {
  const auto logarithm = [&](int64_t n, int k) {
    return sog_logarithm(double(from.at(kMean, n)[k]));
  };
  const SogRange range(from.count, 3, logarithm);
  const std::string files = add_planes("means", from.count, range, logarithm, images);
  return fmt::format(R"("means":{{{},{}}})", range.text(), files);
}

void add_rotations(const GaussianSpans<const float>& from, std::vector<SogImage>& images) {
  RgbaImage image = sog_image(from.count);
  for (int64_t n = 0; n < from.count; ++n) {
    const std::array<uint8_t, 4> bytes = sog_quaternion(from.at(kRotation, n));
    for (int k = 0; k < 4; ++k) image.at(n, k) = bytes[size_t(k)];
  }
  images.push_back({"quats.webp", std::move(image)});
}

ScalarCodebook add_indices(const char* name, const GaussianSpans<const float>& from, Group group,
                           std::vector<SogImage>& images) {
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

std::string add_shapes_and_colours(const GaussianSpans<const float>& from,
                                   std::vector<SogImage>& images) {
  add_rotations(from, images);
  const ScalarCodebook scales = add_indices("scales.webp", from, kLogScale, images);
  const ScalarCodebook colours = add_indices("sh0.webp", from, kSh, images);
  for (int64_t n = 0; n < from.count; ++n)
    images.back().image.at(n, 3) = opacity_byte(*from.at(kOpacityLogit, n));
  return fmt::format(R"("scales":{{"codebook":[{}],"files":["scales.webp"]}},)"
                     R"("quats":{{"files":["quats.webp"]}},)"
                     R"("sh0":{{"codebook":[{}],"files":["sh0.webp"]}})",
                     fmt::join(scales.entries(), ","), fmt::join(colours.entries(), ","));
}

std::string add_harmonics(const GaussianSpans<const float>& from, int sh_degree,
                          std::vector<SogImage>& images) {
  if (sh_degree == 0 || from.count == 0) return "";
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

std::string sog_archive(std::string meta, const std::vector<SogImage>& images) {
  std::vector<ZipEntry> entries{{kSogMeta, std::move(meta)}};
  for (const SogImage& image : images) entries.push_back({image.name, ""});
  parallel_for(int64_t(images.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i)
      entries[size_t(i) + 1].bytes = encode_lossless_webp(images[size_t(i)].image);
  });
  return stored_zip(entries);
}

}  // namespace tessera
