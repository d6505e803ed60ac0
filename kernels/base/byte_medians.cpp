// A median is the largest value that at least so many of the images reach, found from its highest
// bit on, in runs of values that loops of fixed length go through in vectors.
#include "kernels/base/byte_medians.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr size_t kRun = 256;

/// At `count` values from `begin` on; at most kRun.
void medians_of_run(const std::vector<const std::vector<uint8_t>*>& images, size_t begin,
                    size_t count, std::vector<uint8_t>& values, uint8_t* to) {
  const size_t reaching = images.size() - (images.size() - 1) / 2;
  for (size_t k = 0; k < images.size(); ++k)
    std::copy_n(images[k]->data() + begin, count, values.data() + k * kRun);
  uint8_t median[kRun] = {};
  for (int bit = 128; bit > 0; bit /= 2) {
    uint8_t tried[kRun], reached[kRun] = {};
    for (size_t i = 0; i < kRun; ++i) tried[i] = uint8_t(median[i] | bit);
    for (size_t k = 0; k < images.size(); ++k)
      for (size_t i = 0; i < kRun; ++i)
        reached[i] = uint8_t(reached[i] + (values[k * kRun + i] >= tried[i] ? 1 : 0));
    for (size_t i = 0; i < kRun; ++i) median[i] = reached[i] >= reaching ? tried[i] : median[i];
  }
  std::copy_n(median, count, to + begin);
}

/// Standard deviation of the noise of an image, 8-bit units, by the quarter of its values that
/// differs least from the median: up to three quarters of them may move.
double noise_of(const std::vector<uint8_t>& image, const std::vector<uint8_t>& median) {
  constexpr size_t kApart = 7;                 // values that are looked at
  constexpr double kQuarterOfNormal = 0.3186;  // of |x|, by the standard deviation
  int64_t count[256] = {}, all = 0;
  for (size_t i = 0; i < median.size(); i += kApart, ++all)
    ++count[std::abs(int(image[i]) - int(median[i]))];
  const double quarter = double(all) / 4;
  double below = 0;
  int level = 0;
  for (; below + double(count[level]) < quarter; ++level) below += double(count[level]);
  // values were rounded: those of a level lie half a unit to either side, those of 0 on one side
  const double low = level == 0 ? 0 : level - 0.5, width = level == 0 ? 0.5 : 1;
  return (low + width * (quarter - below) / double(count[level])) / kQuarterOfNormal;
}

}  // namespace

std::vector<uint8_t> lower_medians(const std::vector<const std::vector<uint8_t>*>& images) {
  constexpr int64_t kBytesOfTask = 1 << 15;
  check(!images.empty() && images.size() <= kMostOfByteMedian, "lower_medians: 1 to 255 images");
  std::vector<uint8_t> median(images.front()->size());
  for (const std::vector<uint8_t>* image : images)
    check(image->size() == median.size(), "lower_medians: images of one size");
  parallel_for(int64_t(median.size()), kBytesOfTask, [&](int64_t begin, int64_t end) {
    std::vector<uint8_t> values(images.size() * kRun);
    for (auto i = size_t(begin); i < size_t(end); i += kRun)
      medians_of_run(images, i, std::min(kRun, size_t(end) - i), values, median.data());
  });
  return median;
}

int still_limit(const std::vector<const std::vector<uint8_t>*>& images,
                const std::vector<uint8_t>& median) {
  check(!images.empty() && images.front()->size() == median.size(), "still_limit: one size");
  std::vector<double> noise(images.size());
  parallel_for(int64_t(images.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) noise[size_t(i)] = noise_of(*images[size_t(i)], median);
  });
  const auto quarter = noise.begin() + int64_t(noise.size()) / 4;
  std::nth_element(noise.begin(), quarter, noise.end());
  return std::max(kStillLimit, int(std::lround(kStillNoise * *quarter)));
}

}  // namespace tessera
