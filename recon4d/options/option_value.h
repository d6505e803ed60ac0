// The value of an option of any type with its conversion from text and to text, and numbers with
// suffixes, such as 10k, 2M, 5MB and 90s.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "kernels/base/enum_names.h"

namespace tessera {

using OptionValue = std::variant<bool, int64_t, double, std::string>;

/// "true" and "false", whole and other numbers ("7", "1e3", ".5", "+1"); everything else is text.
OptionValue option_value_from_text(const std::string& text);
/// The text that option_value_from_text reads as this value.
std::string plain_text(const OptionValue& value);
/// The same with text in quotes.
std::string quoted_text(const OptionValue& value);

/// Which suffixes the text of a number may have.
enum class Unit {
  kNone,
  kCount,    // k, M, G: powers of 1,000
  kBytes,    // k, M, G, kB, MB, GB: powers of 1,000; KiB, MiB, GiB: of 1,024
  kSeconds,  // h, m, s, ms, also together: 1h30m
  kWorld     // world units: none
};
template <>
inline constexpr const char* kEnumNames<Unit>[] = {"", "count", "bytes", "seconds", "world units"};

/// The number that `text` states, as "1500", "1.5k" or "5MB"; none where it is not one of this
/// unit. Blanks may stand before the letters, which count without regard to case, but for m
/// (minutes, not millions) in kSeconds.
std::optional<double> parse_quantity(const std::string& text, Unit unit);

/// What such a text may look like, for messages: "a number like 1500, 10k or 2M".
const char* quantity_example(Unit unit);

}  // namespace tessera
