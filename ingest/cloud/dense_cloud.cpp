// Tries random pixels in rounds, no larger than what is missing asks for, until there are enough
// points. Static points are limited to one a voxel, moving points to one a voxel and timestep.
#include "ingest/cloud/dense_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "ingest/cloud/plane_sweep.h"
#include "kernels/math/random.h"

namespace tessera {
namespace {

/// Cells of one to two pixels where the point was found: 2^level world units wide.
class Voxels {
 public:
  /// Whether nothing was there before. `timestep`: of the frame that it was found in.
  bool take(const SweptPoint& point, int64_t timestep) {
    const int level = int(std::floor(std::log2(point.pixel))) + 1;
    const auto cell = [&](float x) { return int64_t(std::floor(std::ldexp(double(x), -level))); };
    return taken_
        .insert({level, cell(point.position.x), cell(point.position.y), cell(point.position.z),
                 point.still ? -1 : timestep})
        .second;
  }

 private:
  using Cell = std::array<int64_t, 5>;
  struct Hash {
    size_t operator()(const Cell& cell) const {
      uint64_t hash = 0;
      for (const int64_t value : cell) {
        hash = (hash ^ uint64_t(value)) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
      }
      return size_t(hash);
    }
  };
  std::unordered_set<Cell, Hash> taken_;
};

/// Tries of the next round: as many as what is missing needs by the yield so far, and some more.
int64_t round_size(int64_t missing, int64_t found, int64_t tried) {
  constexpr int64_t kFewest = 256, kMost = 8192;
  constexpr double kFirstYield = 0.5, kLeastYield = 0.02, kMore = 1.1;
  const double yield =
      tried == 0 ? kFirstYield : std::max(kLeastYield, double(found) / double(tried));
  return std::clamp(int64_t(kMore * double(missing) / yield), kFewest, kMost);
}

ViewPixel random_pixel(const PlaneSweep& sweep, uint64_t seed, int64_t number) {
  const RandomBlock random = philox(seed, RandomStream::kInitialise, uint64_t(number), 2);
  const int frame = sweep.frames()[random.word[0] % uint32_t(sweep.frames().size())];
  const Image8& image = sweep.scene().frames[size_t(frame)].image;
  return {frame, int(uniform(random.word[1]) * float(image.width)),
          int(uniform(random.word[2]) * float(image.height))};
}

/// For each try from `begin` on, the first of a few random pixels that belongs to the part, if one
/// does.
std::vector<ViewPixel> pixels_of(const PlaneSweep& sweep, const CloudOptions& options,
                                 int64_t begin, int64_t count) {
  constexpr int64_t kPixels = 32;
  if (options.part == CloudPart::kAll) {
    std::vector<ViewPixel> pixels;
    for (int64_t i = begin; i < begin + count; ++i)
      pixels.push_back(random_pixel(sweep, options.seed, i));
    return pixels;
  }
  return sweep.first_of(count, kPixels, options.part == CloudPart::kMoving, [&](int64_t i) {
    return random_pixel(sweep, options.seed, begin * kPixels + i);
  });
}

}  // namespace

std::vector<SweptPoint> dense_points(const PlaneSweep& sweep, const CloudOptions& options) {
  std::vector<SweptPoint> points;
  if (sweep.frames().empty()) return points;
  Voxels voxels;
  const int64_t tries = kTriesAPoint * options.points;
  int64_t count = 0;
  for (int64_t begin = 0; begin < tries; begin += count) {
    const auto have = int64_t(points.size());
    count = std::min(round_size(options.points - have, have, begin), tries - begin);
    if (options.progress) options.progress(have);
    for (const SweptPoint& point : sweep.find(pixels_of(sweep, options, begin, count))) {
      if (int64_t(points.size()) == options.points) return points;
      if (voxels.take(point, sweep.scene().frames[size_t(point.frame)].timestep))
        points.push_back(point);
    }
  }
  return points;
}

PointCloud cloud_of(const std::vector<SweptPoint>& points) {
  PointCloud cloud;
  for (const SweptPoint& point : points) {
    cloud.position.push_back(point.position);
    cloud.colour.push_back(point.colour);
    cloud.time.push_back(point.time);
    cloud.still.push_back(point.still);
    cloud.velocity.push_back(point.velocity);
  }
  return cloud;
}

}  // namespace tessera
