// What: the value of one option, whatever its type, and how it is read from text and shown.
// Not: which options there are (train_options.h), nor JSON (train_options_json.h).
#pragma once
#include <cstdint>
#include <string>
#include <variant>

namespace tessera {

using OptionValue = std::variant<bool, int64_t, double, std::string>;

/// "true" and "false", whole and other numbers ("7", "1e3", ".5", "+1"); everything else is text.
OptionValue option_value_from_text(const std::string& text);
/// The text that option_value_from_text reads as this value.
std::string plain_text(const OptionValue& value);
/// The same with text in quotes.
std::string quoted_text(const OptionValue& value);

}  // namespace tessera
