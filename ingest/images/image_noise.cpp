// Noise by the second difference in both directions, which planes and edges along an axis leave at
// zero.
#include "ingest/images/image_noise.h"

#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr int kTile = 16;  // pixels
constexpr size_t kLeastTiles = 20;
constexpr double kDarkest = 8, kBrightest = 247;  // means of tiles that count, levels

struct TileNoise {
  double mean = 0, deviation = 0;
};

/// Of the pixels from (x0, y0) on, all of which have eight neighbours.
TileNoise noise_of_tile(const Image8& image, int x0, int y0) {
  // variance of the second difference in x and y of independent values, by theirs
  constexpr double kGain = 36;
  double sum = 0, squares = 0;
  for (int y = y0; y < y0 + kTile; ++y)
    for (int x = x0; x < x0 + kTile; ++x) {
      const auto green = [&](int dx, int dy) {
        return int(image.data[3 * (size_t(y + dy) * size_t(image.width) + size_t(x + dx)) + 1]);
      };
      const int difference = green(-1, -1) - 2 * green(0, -1) + green(1, -1) - 2 * green(-1, 0) +
                             4 * green(0, 0) - 2 * green(1, 0) + green(-1, 1) - 2 * green(0, 1) +
                             green(1, 1);
      sum += green(0, 0);
      squares += double(difference) * difference;
    }
  constexpr double kPixels = kTile * kTile;
  return {sum / kPixels, std::sqrt(squares / kPixels / kGain)};
}

}  // namespace

double image_noise(const Image8& image, const FrameMask& mask) {
  constexpr double kFlattest = 0.1;
  std::vector<double> deviations;
  for (int y = 1; y + kTile < image.height; y += kTile)
    for (int x = 1; x + kTile < image.width; x += kTile) {
      if (mask.ignores(x + kTile / 2, y + kTile / 2)) continue;
      const TileNoise tile = noise_of_tile(image, x, y);
      if (tile.mean > kDarkest && tile.mean < kBrightest) deviations.push_back(tile.deviation);
    }
  return deviations.size() < kLeastTiles ? 0 : quantile(std::move(deviations), kFlattest);
}

double image_noise(const Scene& scene) {
  std::set<std::string> measured;
  std::vector<double> noise;
  for (const Frame& frame : scene.frames)
    if (frame.split == Split::kTrain && !frame.image.data.empty() &&
        measured.insert(frame.camera_name).second)
      noise.push_back(image_noise(frame.image, frame.mask));
  return noise.empty() ? 0 : quantile(std::move(noise), 0.5);
}

}  // namespace tessera
