// Makes the token and compares it with what a browser sends.
#include "tools/view/view_token.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <stdexcept>

namespace tessera {

std::string make_view_token() {
  std::array<unsigned char, 16> random{};
  if (::getentropy(random.data(), random.size()) != 0)
    throw std::runtime_error("view: the kernel gives no random numbers for the token");
  return fmt::format("{:02x}", fmt::join(random, ""));
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char differences = 0;  // volatile: the compiler must not leave the loop early
  for (size_t i = 0; i < a.size(); ++i)
    differences = differences | static_cast<unsigned char>(a[i] ^ b[i]);
  return differences == 0;
}

std::string view_cookie_name(uint16_t port) {
  return fmt::format("tessera_view_{}", port);
}

bool cookies_have(std::string_view header, std::string_view name, std::string_view value) {
  bool found = false;
  while (!header.empty()) {
    std::string_view cookie = header.substr(0, header.find(';'));
    header.remove_prefix(std::min(header.size(), cookie.size() + 1));
    cookie.remove_prefix(std::min(cookie.size(), cookie.find_first_not_of(' ')));
    const size_t equals = cookie.find('=');
    if (equals == std::string_view::npos || cookie.substr(0, equals) != name) continue;
    found |= equal_in_constant_time(cookie.substr(equals + 1), value);
  }
  return found;
}

}  // namespace tessera
