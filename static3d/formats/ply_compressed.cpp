// The compressed .ply of SuperSplat and PlayCanvas: chunks of 256 splats with ranges, 16 packed
// bytes for each splat, and optional 8-bit SH. Source: formats 1.2 (the PlayCanvas engine's, MIT),
// written from its layout.
#include "static3d/formats/splat_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "static3d/transform/far_gaussians.h"
#include "static3d/transform/splat_quanta.h"

namespace tessera {
namespace {

constexpr int64_t kSplatsPerChunk = 256;  // share their ranges

const std::vector<double>& values_of(const std::filesystem::path& path, const PlyElement& element,
                                     const std::string& name) {
  if (const PlyColumn* const column = element.find(name)) return column->values;
  throw InputError(
      fmt::format("{}: element '{}' has no property '{}', expected a compressed splat .ply; export "
                  "it again",
                  path.string(), element.name, name));
}

/// Words of 32 bits.
const std::vector<double>& words_of(const std::filesystem::path& path, const PlyElement& vertex,
                                    const char* property) {
  const std::string name = property;
  const std::vector<double>& words = values_of(path, vertex, name);
  if (vertex.find(name)->type == PlyType::kUint32) return words;
  throw InputError(fmt::format(
      "{}: property '{}' is not of type uint, expected a compressed splat .ply; export it again",
      path.string(), name));
}

/// Three ranges of a chunk: [min, max] of three columns.
struct Range {
  const std::vector<double>*low[3], *high[3];
  double at(int axis, int64_t chunk, double f) const {
    const double a = (*low[axis])[size_t(chunk)], b = (*high[axis])[size_t(chunk)];
    return a + f * (b - a);
  }
};

Range range_of(const std::filesystem::path& path, const PlyElement& chunks,
               const std::array<const char*, 3>& names) {
  Range range;
  for (size_t k = 0; k < 3; ++k) {
    range.low[k] = &values_of(path, chunks, fmt::format("min_{}", names[k]));
    range.high[k] = &values_of(path, chunks, fmt::format("max_{}", names[k]));
  }
  return range;
}

void decode_vector(uint32_t word, const Range& range, int64_t chunk, float* out) {
  const double f[3] = {fraction_of(word, 21, 11), fraction_of(word, 11, 10),
                       fraction_of(word, 0, 11)};
  for (int k = 0; k < 3; ++k) out[k] = float(range.at(k, chunk, f[k]));
}

void decode_sh(const std::filesystem::path& path, const PlyFile& file,
               const GaussianSpans<float>& set) {
  const int rest = set.coefficients - 1;
  for (int i = 0; i < 3 * rest; ++i) {
    const std::string name = fmt::format("f_rest_{}", i);
    const std::vector<double>& column = values_of(path, *file.find("sh"), name);
    for (int64_t n = 0; n < set.count; ++n) {
      const double byte = column[size_t(n)];
      const double f = byte == 0 ? 0 : byte == 255 ? 1 : (byte + 0.5) / 256;
      set.at(kSh, n)[3 * (i % rest + 1) + i / rest] = float(8 * (f - 0.5));
    }
  }
}

int coefficients_of(const std::filesystem::path& path, const PlyFile& file) {
  const PlyElement* const sh = file.find("sh");
  if (sh == nullptr) return 1;
  for (int degree = 1; degree <= kMaxShDegree; ++degree)
    if (int(sh->columns.size()) == 3 * (sh_coefficients(degree) - 1) &&
        sh->rows == file.find("vertex")->rows)
      return sh_coefficients(degree);
  throw InputError(fmt::format(
      "{}: element 'sh' has {} columns and {} rows, expected 9, 24 or 45 and one per vertex; "
      "export it again",
      path.string(), sh->columns.size(), sh->rows));
}

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

std::string header(int64_t count, int rest, bool antialiased) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  if (antialiased) text += fmt::format("comment {}\n", kAntialiasedComment);
  text += fmt::format("element chunk {}\n", (count + kSplatsPerChunk - 1) / kSplatsPerChunk);
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

bool is_compressed_splat(const PlyFile& file) {
  const PlyElement* const vertex = file.find("vertex");
  return file.find("chunk") != nullptr && vertex != nullptr &&
         vertex->find("packed_position") != nullptr;
}

GaussianSet decode_compressed_splat(const std::filesystem::path& path, const PlyFile& file) {
  const PlyElement &chunks = *file.find("chunk"), &vertex = *file.find("vertex");
  if (chunks.rows * kSplatsPerChunk < vertex.rows)
    throw InputError(fmt::format("{}: {} chunks for {} splats, expected one per {}; export again",
                                 path.string(), chunks.rows, vertex.rows, kSplatsPerChunk));
  const Range mean = range_of(path, chunks, {"x", "y", "z"});
  const Range scale = range_of(path, chunks, {"scale_x", "scale_y", "scale_z"});
  const bool ranged_colour = chunks.find("min_r") != nullptr;  // absent before SuperSplat 1.9
  const Range colour = ranged_colour ? range_of(path, chunks, {"r", "g", "b"}) : Range{};
  const auto& position = words_of(path, vertex, "packed_position");
  const auto& rotation = words_of(path, vertex, "packed_rotation");
  const auto& scales = words_of(path, vertex, "packed_scale");
  const auto& rgba = words_of(path, vertex, "packed_color");
  GaussianSet set(SetForm::kStatic, coefficients_of(path, file));
  set.resize(vertex.rows);
  const GaussianSpans<float> to = set.values();
  for (int64_t n = 0; n < vertex.rows; ++n) {
    const int64_t chunk = n / kSplatsPerChunk;
    decode_vector(uint32_t(position[size_t(n)]), mean, chunk, to.at(kMean, n));
    decode_vector(uint32_t(scales[size_t(n)]), scale, chunk, to.at(kLogScale, n));
    quaternion_of(uint32_t(rotation[size_t(n)]), to.at(kRotation, n));
    const uint32_t word = uint32_t(rgba[size_t(n)]);
    *to.at(kOpacityLogit, n) = logit_of_byte(double(word & 255));
    for (int c = 0; c < 3; ++c) {
      const double f = fraction_of(word, 24 - 8 * c, 8);
      const double linear = ranged_colour ? colour.at(c, chunk, f) : f;
      to.at(kSh, n)[c] = float((linear - 0.5) / kSh0);
    }
  }
  decode_sh(path, file, to);
  return set;
}

int64_t save_compressed_splat(const std::filesystem::path& path, const GaussianSet& set,
                              const SplatDrawing& drawing) {
  const HeldRows held = rows_in_chunks(set.values(), kSplatsPerChunk);
  const GaussianSet ordered = select_elements(set, held.rows);
  const GaussianSpans<const float> values = ordered.values();
  const int64_t count = ordered.count();
  const int rest = sh_coefficients(drawing.sh_degree) - 1;
  std::string bytes = header(count, rest, drawing.antialiased), splats, sh;
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
  return int64_t(held.beyond.size());
}

}  // namespace tessera
