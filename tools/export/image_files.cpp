// Converts planar floats to interleaved rows. Values are display-referred, as trained; there is no
// colour management.
#include "tools/export/image_files.h"

#include <fmt/format.h>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "recon4d/evaluation/metrics.h"

namespace tessera {

void write_image_png(const std::filesystem::path& path, const RenderedImage& image) {
  write_png(path, quantise(image.planar(), image.width, image.height));
}

void write_image_png_alpha(const std::filesystem::path& path, const RenderedImage& image) {
  const size_t pixels = image.alpha.size();
  std::vector<float> straight(3 * pixels, 0.0f);
  std::vector<float> opaqueness(3 * pixels);
  for (size_t c = 0; c < 3; ++c)
    for (size_t p = 0; p < pixels; ++p) {
      const float alpha = image.alpha[p];
      if (alpha > 0) straight[c * pixels + p] = image.rgb[c * pixels + p] / alpha;
      opaqueness[c * pixels + p] = alpha;
    }
  const auto rounded = [&](const std::vector<float>& planar) {
    return quantise({planar.data(), int64_t(planar.size())}, image.width, image.height);
  };
  const Image8 rgb = rounded(straight), alpha = rounded(opaqueness);
  Image8 stored{image.width, image.height, 4, std::vector<uint8_t>(4 * pixels)};
  for (size_t p = 0; p < pixels; ++p) {
    for (size_t c = 0; c < 3; ++c) stored.data[4 * p + c] = rgb.data[3 * p + c];
    stored.data[4 * p + 3] = alpha.data[3 * p];
  }
  write_png(path, stored);
}

void write_image_pfm(const std::filesystem::path& path, const RenderedImage& image) {
  const size_t width = size_t(image.width), pixels = image.alpha.size();
  AtomicFile file(path);
  file.write(fmt::format("PF\n{} {}\n-1.0\n", image.width, image.height));
  std::vector<float> row(3 * width);
  for (int y = image.height - 1; y >= 0; --y) {
    for (size_t x = 0; x < width; ++x)
      for (size_t c = 0; c < 3; ++c) row[3 * x + c] = image.rgb[c * pixels + size_t(y) * width + x];
    file.write(row.data(), row.size() * sizeof(float));
  }
  file.commit();
}

}  // namespace tessera
