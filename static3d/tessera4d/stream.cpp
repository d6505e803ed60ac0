// Rounding of numbers, zigzag differences and byte planes.
#include "static3d/tessera4d/stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "ingest/files/gzip.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kMostWord = (1 << 24) - 1;

StreamType type_for(double most) {
  if (most <= UINT8_MAX) return StreamType::kU8;
  return most <= UINT16_MAX ? StreamType::kU16 : StreamType::kU24;
}

/// All bits that a word of the type has.
uint32_t mask_of(StreamType type) {
  return uint32_t((uint64_t{1} << (8 * bytes_of(type))) - 1);
}

uint32_t zigzag(uint32_t difference, uint32_t mask) {
  const uint32_t sign = (mask >> 1) + 1;  // the top bit
  return (difference & sign) != 0 ? (~(difference << 1) & mask) : difference << 1;
}
uint32_t unzigzag(uint32_t z, uint32_t mask) {
  return ((z >> 1) ^ (0 - (z & 1))) & mask;
}

std::string planes_of(const StreamWords& stream) {
  const uint32_t mask = mask_of(stream.info.type);
  const int width = bytes_of(stream.info.type);
  std::string planes;
  planes.reserve(stream.words.size() * size_t(width));
  for (int c = 0; c < stream.info.components; ++c)
    for (int byte = 0; byte < width; ++byte) {
      uint32_t before = 0;
      for (int64_t n = 0; n < stream.info.count; ++n) {
        const uint32_t word = stream.component(c)[n];
        const uint32_t stored = stream.info.delta ? zigzag((word - before) & mask, mask) : word;
        planes.push_back(char(stored >> (8 * byte) & 0xff));
        before = word;
      }
    }
  return planes;
}

}  // namespace

StreamWords quantised(std::string name, int components, const std::vector<float>& values,
                      double step, bool delta) {
  StreamWords stream;
  StreamInfo& info = stream.info;
  info.name = std::move(name);
  info.components = components;
  info.delta = delta;
  info.count = int64_t(values.size()) / components;
  stream.words.resize(values.size());
  double most = 0;
  for (int c = 0; c < components; ++c) {
    const auto begin = values.begin() + c * info.count, end = begin + info.count;
    const auto [low, high] = std::minmax_element(begin, end);
    const double range = info.count > 0 ? double(*high) - double(*low) : 0;
    const double s = std::max(step, range / (kMostWord - 2));
    const double first = info.count > 0 ? std::floor(double(*low) / s) : 0;
    for (int64_t n = 0; n < info.count; ++n) {
      const double word = std::max(0.0, std::round(double(begin[n]) / s - first));
      stream.component(c)[n] = uint32_t(word);
      most = std::max(most, word);
    }
    info.scale.push_back(s);
    info.bias.push_back(first * s);
  }
  info.type = type_for(most);
  return stream;
}

StreamWords bytes_of_unit(std::string name, const std::vector<float>& values) {
  StreamWords stream = quantised(std::move(name), 1, values, 1.0 / 255);
  const auto first = uint32_t(std::lround(stream.info.bias[0] * 255));
  for (uint32_t& word : stream.words) word += first;
  stream.info.bias[0] = 0;
  return stream;
}

StreamWords as_floats(std::string name, int components, const std::vector<float>& values) {
  StreamWords stream;
  stream.info.name = std::move(name);
  stream.info.components = components;
  stream.info.type = StreamType::kF32;
  stream.info.count = int64_t(values.size()) / components;
  for (float value : values) stream.words.push_back(std::bit_cast<uint32_t>(value));
  return stream;
}

float value_at(const StreamWords& stream, int component, int64_t n) {
  const uint32_t word = stream.component(component)[n];
  if (stream.info.type == StreamType::kF32) return std::bit_cast<float>(word);
  const auto c = size_t(component);
  return float(stream.info.bias[c] + stream.info.scale[c] * double(word));
}

std::string packed_stream(const StreamWords& stream, int gzip_level) {
  return gzip(planes_of(stream), gzip_level);
}

StreamWords read_stream(std::string_view block, const StreamInfo& info,
                        const std::filesystem::path& path) {
  const int width = bytes_of(info.type);
  const uint64_t expected = uint64_t(info.components) * uint64_t(width) * uint64_t(info.count);
  check(info.offset <= block.size() && info.bytes <= block.size() - info.offset,
        "read_stream: a stream beyond its block");
  std::string planes(block.substr(info.offset, info.bytes));
  if (info.gzip) planes = gunzip(planes, expected, path);
  if (planes.size() != expected)
    throw InputError(
        fmt::format("{}: stream '{}' has {} bytes, expected {}; fetch or export it again",
                    path.string(), info.name, planes.size(), expected));
  StreamWords stream{info, std::vector<uint32_t>(expected / uint64_t(width))};
  const uint32_t mask = mask_of(info.type);
  const auto* plane = reinterpret_cast<const unsigned char*>(planes.data());
  for (int c = 0; c < info.components; ++c) {
    for (int byte = 0; byte < width; ++byte, plane += info.count)
      for (int64_t n = 0; n < info.count; ++n)
        stream.component(c)[n] |= uint32_t(plane[n]) << (8 * byte);
    if (!info.delta) continue;
    uint32_t sum = 0;
    for (int64_t n = 0; n < info.count; ++n)
      stream.component(c)[n] = sum = (sum + unzigzag(stream.component(c)[n], mask)) & mask;
  }
  return stream;
}

}  // namespace tessera
