// What: option values from text and back.
// Not: their ranges (train_options.cpp).
#include "recon4d/options/option_value.h"

#include <fmt/format.h>

#include <charconv>

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

}  // namespace tessera
