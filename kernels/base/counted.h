// How many of a thing there are, in words.
#pragma once
#include <cstdint>
#include <string>

namespace tessera {

/// "1 camera", "2 cameras".
inline std::string counted(int64_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace tessera
