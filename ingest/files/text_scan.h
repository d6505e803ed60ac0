// Takes pieces off the front of a text: for short lines and names that others wrote.
#pragma once
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>

namespace tessera {

/// Takes the digits that `text` begins with, at most `most` of them; nothing where there are none,
/// or more than a number of 64 bits has.
inline std::optional<int64_t> take_number(std::string_view& text, size_t most) {
  int64_t number = 0;
  const char* const begin = text.data();
  if (text.empty() || *begin < '0' || *begin > '9') return std::nullopt;
  const auto parsed = std::from_chars(begin, begin + std::min(text.size(), most), number);
  if (parsed.ec != std::errc{}) return std::nullopt;
  text.remove_prefix(size_t(parsed.ptr - begin));
  return number;
}

/// Takes `word`, or nothing where `text` begins otherwise.
inline bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

/// Takes one character of `these`, or nothing.
inline bool take_one_of(std::string_view& text, std::string_view these) {
  if (text.empty() || these.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace tessera
