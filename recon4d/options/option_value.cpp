// Parsing of option values and of numbers with suffixes; each unit has one table of suffixes.
#include "recon4d/options/option_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// Whether all of `text` is a number of this type that it can hold.
template <class Number>
bool parse_whole(const std::string& text, Number& number) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const char* const begin = text.data() + (plus ? 1 : 0);
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, number);
  return error == std::errc() && rest == end;
}

using Suffixes = std::vector<std::pair<const char*, double>>;

const Suffixes& suffixes(Unit unit) {
  static const Suffixes none,
      count = {{"k", 1e3}, {"m", 1e6}, {"g", 1e9}},
      bytes = {{"b", 1},   {"k", 1e3},  {"kb", 1e3},      {"m", 1e6},       {"mb", 1e6},
               {"g", 1e9}, {"gb", 1e9}, {"kib", 1 << 10}, {"mib", 1 << 20}, {"gib", 1 << 30}},
      seconds = {{"ms", 1e-3}, {"s", 1}, {"m", 60}, {"h", 3600}};
  switch (unit) {
    case Unit::kCount:
      return count;
    case Unit::kBytes:
      return bytes;
    case Unit::kSeconds:
      return seconds;
    default:
      return none;
  }
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

const char* skip_blanks(const char* cursor, const char* end) {
  while (cursor != end && *cursor == ' ') ++cursor;
  return cursor;
}

/// A number and the letters after it, with or without blanks between; moves `cursor` past both.
std::optional<double> parse_term(const char*& cursor, const char* end, Unit unit,
                                 bool& has_suffix) {
  double number = 0;
  const bool plus = cursor != end && *cursor == '+';
  const auto [after, error] = std::from_chars(cursor + (plus ? 1 : 0), end, number);
  if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
  std::string letters;
  const char* const word = skip_blanks(after, end);
  for (cursor = word != end && is_letter(*word) ? word : after; cursor != end && is_letter(*cursor);
       ++cursor)
    letters += char(*cursor >= 'A' && *cursor <= 'Z' ? *cursor - 'A' + 'a' : *cursor);
  has_suffix = !letters.empty();
  if (!has_suffix) return number;
  for (const auto& [suffix, factor] : suffixes(unit))
    if (letters == suffix) return number * factor;
  return std::nullopt;
}

}  // namespace

OptionValue option_value_from_text(const std::string& text) {
  if (text == "true") return true;
  if (text == "false") return false;
  if (int64_t whole = 0; parse_whole(text, whole)) return whole;
  if (double number = 0; parse_whole(text, number)) return number;
  return text;
}

std::string plain_text(const OptionValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* truth = std::get_if<bool>(&value)) return *truth ? "true" : "false";
  if (const auto* whole = std::get_if<int64_t>(&value)) return fmt::format("{}", *whole);
  return fmt::format("{}", std::get<double>(value));
}

std::string quoted_text(const OptionValue& value) {
  const std::string text = plain_text(value);
  return std::holds_alternative<std::string>(value) ? '"' + text + '"' : text;
}

std::optional<double> parse_quantity(const std::string& text, Unit unit) {
  const char *cursor = text.data(), *const end = cursor + text.size();
  bool has_suffix = false;
  std::optional<double> sum = parse_term(cursor, end, unit, has_suffix);
  // 1h30m: every part has its unit
  while (sum && cursor != end) {
    if (unit != Unit::kSeconds || !has_suffix) return std::nullopt;
    cursor = skip_blanks(cursor, end);
    const std::optional<double> next = parse_term(cursor, end, unit, has_suffix);
    if (!next || !has_suffix) return std::nullopt;
    sum = *sum + *next;
  }
  return sum;
}

const char* quantity_example(Unit unit) {
  switch (unit) {
    case Unit::kCount:
      return "a whole number like 1500, 10k or 2M";
    case Unit::kBytes:
      return "bytes like 500000, 500kB, 5MB or 5MiB";
    case Unit::kSeconds:
      return "seconds like 90, or 90s, 2h or 1h30m";
    default:
      return "a number";
  }
}

}  // namespace tessera
