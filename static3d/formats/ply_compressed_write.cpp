// What: stored parameters of a static set → bit fields.
// Not: the way back (ply_compressed.cpp).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/ply_compressed.h"
#include "static3d/transform/morton_order.h"
#include "static3d/transform/splat_quanta.h"

namespace tessera {
namespace {

/// The nine numbers of a splat that have ranges, as they are stored: mean, ln scale, colour.
std::array<float, 9> ranged(const GaussianSpans<const float>& set, int64_t n) {
  constexpr float kMostLog = 20;
  std::array<float, 9> v{};
  for (size_t k = 0; k < 3; ++k) {
    v[k] = set.at(kMean, n)[k];
    v[3 + k] = std::clamp(set.at(kLogScale, n)[k], -kMostLog, kMostLog);
    v[6 + k] = float(kSh0 * double(set.at(kSh, n)[k]) + 0.5);
  }
  return v;
}

struct ChunkRange {
  std::array<float, 9> low, high;

  ChunkRange(const GaussianSpans<const float>& set, int64_t begin, int64_t end) {
    low.fill(INFINITY);
    high.fill(-INFINITY);
    for (int64_t n = begin; n < end; ++n) {
      const std::array<float, 9> v = ranged(set, n);
      for (size_t k = 0; k < 9; ++k) {
        low[k] = std::min(low[k], v[k]);
        high[k] = std::max(high[k], v[k]);
      }
    }
  }
  /// 0 to 1; 0 where the range is nothing.
  double unit(size_t k, float value) const {
    constexpr double kNoRange = 1e-5;
    const double range = double(high[k]) - low[k];
    return range < kNoRange ? 0 : (double(value) - low[k]) / range;
  }
};

uint32_t packed_vector(const ChunkRange& range, const std::array<float, 9>& v, size_t first) {
  return bits_of(range.unit(first, v[first]), 11) << 21 |
         bits_of(range.unit(first + 1, v[first + 1]), 10) << 11 |
         bits_of(range.unit(first + 2, v[first + 2]), 11);
}

uint32_t packed_colour(const ChunkRange& range, const std::array<float, 9>& v, float logit) {
  return bits_of(range.unit(6, v[6]), 8) << 24 | bits_of(range.unit(7, v[7]), 8) << 16 |
         bits_of(range.unit(8, v[8]), 8) << 8 | opacity_byte(logit);
}

std::string header(int64_t count, int rest) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\nelement chunk {}\n",
                                 (count + kSplatsPerChunk - 1) / kSplatsPerChunk);
  for (const char* group : {"x y z", "scale_x scale_y scale_z", "r g b"})
    for (const char* end : {"min", "max"}) {
      std::string_view names = group;
      while (!names.empty()) {
        const std::string_view name = names.substr(0, names.find(' '));
        text += fmt::format("property float {}_{}\n", end, name);
        names.remove_prefix(std::min(names.size(), name.size() + 1));
      }
    }
  text += fmt::format("element vertex {}\n", count);
  for (const char* name : {"position", "rotation", "scale", "color"})
    text += fmt::format("property uint packed_{}\n", name);
  if (rest > 0) text += fmt::format("element sh {}\n", count);
  for (int i = 0; i < 3 * rest; ++i) text += fmt::format("property uchar f_rest_{}\n", i);
  return text + "end_header\n";
}

void append_range(std::string& bytes, const ChunkRange& range) {
  for (size_t first : {0, 3, 6})
    for (const std::array<float, 9>* ends : {&range.low, &range.high})
      for (size_t k = 0; k < 3; ++k) append(bytes, (*ends)[first + k]);
}

/// Channel by channel, as the reference stores them.
void append_sh_channels(std::string& bytes, const float* sh, int rest) {
  for (int c = 0; c < 3; ++c)
    for (int i = 1; i <= rest; ++i)
      append(bytes,
             uint8_t(std::clamp(std::trunc((double(sh[3 * i + c]) / 8 + 0.5) * 256), 0.0, 255.0)));
}

}  // namespace

void save_compressed_splat(const std::filesystem::path& path, const GaussianSet& set,
                           int sh_degree) {
  const GaussianSet ordered = select_elements(set, morton_order(set.values()));
  const GaussianSpans<const float> values = ordered.values();
  const int64_t count = ordered.count();
  const int rest = sh_coefficients(sh_degree) - 1;
  std::string bytes = header(count, rest), splats, sh;
  for (int64_t begin = 0; begin < count; begin += kSplatsPerChunk) {
    const int64_t end = std::min(begin + kSplatsPerChunk, count);
    const ChunkRange range(values, begin, end);
    append_range(bytes, range);
    for (int64_t n = begin; n < end; ++n) {
      const std::array<float, 9> v = ranged(values, n);
      append(splats, packed_vector(range, v, 0));
      append(splats, smallest_three(values.at(kRotation, n)));
      append(splats, packed_vector(range, v, 3));
      append(splats, packed_colour(range, v, *values.at(kOpacityLogit, n)));
      append_sh_channels(sh, values.at(kSh, n), rest);
    }
  }
  write_text_file(path, bytes + splats + sh);
}

}  // namespace tessera
