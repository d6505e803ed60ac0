// Reads little-endian numbers from a run of bytes, with a check of its end, and appends them to
// one.
#pragma once
#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "kernels/base/errors.h"

namespace tessera {

static_assert(std::endian::native == std::endian::little, "bytes are copied as they are");

class ByteReader {
 public:
  /// `bytes` must outlive it; `path` is what errors name.
  ByteReader(std::string_view bytes, std::filesystem::path path)
      : bytes_(bytes), path_(std::move(path)) {}

  /// The next `count` bytes. Errors: InputError: fewer are left.
  std::string_view take(uint64_t count) {
    if (count > left())
      throw InputError(
          fmt::format("{}: ends after {} bytes where {} more are promised; it is cut "
                      "off, fetch or export it again",
                      path_.string(), bytes_.size(), count - left()));
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }
  /// `count` rows of `width` bytes, without overflow.
  std::string_view take_elements(uint64_t count, uint64_t width) {
    return take(width > 0 && count > bytes_.size() / width ? bytes_.size() + 1 : count * width);
  }
  template <typename T>
  T number() {
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  uint64_t left() const { return bytes_.size() - at_; }

 private:
  std::string_view bytes_;
  std::filesystem::path path_;
  uint64_t at_ = 0;
};

template <typename T>
void append(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

}  // namespace tessera
