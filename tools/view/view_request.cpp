// Finds headers by their names, makes the token and compares it with the cookie.
#include "tools/view/view_request.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

/// The host of host, host:port, [address] or [address]:port; "" for all that is none of these.
std::string_view host_of(std::string_view authority) {
  const size_t end = authority.starts_with('[') ? authority.find(']') + 1 : authority.find(':');
  const std::string_view host = authority.substr(0, std::min(end, authority.size()));
  const std::string_view rest = authority.substr(host.size());
  const bool is_port = rest.starts_with(':') && rest.size() <= 6 &&
                       rest.find_first_not_of("0123456789", 1) == std::string_view::npos;
  return rest.empty() || is_port ? host : std::string_view();
}

}  // namespace

std::vector<std::string_view> header_values(const HttpHeaders& headers, std::string_view name) {
  std::vector<std::string_view> values;
  for (const auto& [header, value] : headers)
    if (lower_case(header) == lower_case(name)) values.push_back(value);
  return values;
}

bool is_host_allowed(const ViewRequest& request, const std::vector<std::string>& allowed) {
  const std::vector<std::string_view> hosts = header_values(request.headers, "Host");
  if (hosts.size() != 1) return false;
  const std::string host = lower_case(host_of(hosts[0]));
  if (host == "localhost" || host == "127.0.0.1" || host == "[::1]") return true;
  return !host.empty() && std::any_of(allowed.begin(), allowed.end(),
                                      [&](const auto& name) { return lower_case(name) == host; });
}

bool is_origin_allowed(const ViewRequest& request) {
  const std::vector<std::string_view> origins = header_values(request.headers, "Origin");
  if (origins.empty()) return request.method != "POST";
  const std::vector<std::string_view> hosts = header_values(request.headers, "Host");
  const std::string host = hosts.empty() ? "" : lower_case(hosts[0]);
  return std::all_of(origins.begin(), origins.end(), [&](std::string_view origin) {
    const std::string lower = lower_case(origin);
    return lower == "http://" + host || lower == "https://" + host;  // https: behind a proxy
  });
}

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
