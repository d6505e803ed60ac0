// Reads one range: first-last, first- or -suffix.
#include "tools/view/byte_range.h"

#include <algorithm>
#include <charconv>

namespace tessera {
namespace {

constexpr std::string_view kUnit = "bytes=";
constexpr size_t kMostDigits = 18;  // so that sums stay within 64 bits

bool is_number(std::string_view text) {
  return !text.empty() && text.size() <= kMostDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

uint64_t number(std::string_view digits) {
  uint64_t value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

}  // namespace

bool is_byte_range(std::string_view header) {
  return header.starts_with(kUnit);
}

std::optional<ByteRange> parse_byte_range(std::string_view header, uint64_t size) {
  if (!is_byte_range(header) || size == 0) return {};
  const std::string_view range = header.substr(kUnit.size());
  const size_t dash = range.find('-');
  if (dash == std::string_view::npos) return {};
  const std::string_view first = range.substr(0, dash), last = range.substr(dash + 1);
  if (first.empty()) {
    if (!is_number(last) || number(last) == 0) return {};
    const uint64_t bytes = std::min(number(last), size);
    return ByteRange{size - bytes, bytes};
  }
  if (!is_number(first) || number(first) >= size) return {};
  if (last.empty()) return ByteRange{number(first), size - number(first)};
  if (!is_number(last) || number(last) < number(first)) return {};
  return ByteRange{number(first), std::min(number(last), size - 1) - number(first) + 1};
}

}  // namespace tessera
