// The names of the values of enumerations, as files and messages have them: one table each, beside
// its enumeration.
#pragma once
#include <cstddef>
#include <type_traits>

namespace tessera {

/// In the order of the values.
template <class Enum>
inline constexpr std::nullptr_t kEnumNames = nullptr;

template <class Enum>
requires std::is_enum_v<Enum>
constexpr const char* name_of(Enum value) {
  return kEnumNames<Enum>[size_t(value)];
}

}  // namespace tessera
