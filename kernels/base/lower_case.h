// Names that are compared without regard to case.
#pragma once
#include <string>
#include <string_view>

namespace tessera {

/// With the letters of ASCII in lower case, whatever the locale; other bytes stay.
inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return lower;
}

}  // namespace tessera
