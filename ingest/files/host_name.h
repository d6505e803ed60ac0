// What: the name of this machine, for files and messages that tell whose something is.
// Not: an address.
#pragma once
#include <unistd.h>

#include <array>
#include <string>

namespace tessera {

inline std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

}  // namespace tessera
