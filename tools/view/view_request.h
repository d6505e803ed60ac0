// A request to `tessera view` and the response to it, as values that the transport takes from a
// socket and sends to it. Checks of its origin: the Host header excludes pages that resolved the
// name of their own server to this machine (DNS rebinding), the Origin header excludes pages of
// other servers, and a token excludes other users of the machine, who can reach the port.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/view/served_file.h"

namespace tessera {

using HttpHeaders = std::vector<std::pair<std::string, std::string>>;

struct ViewRequest {
  std::string method;
  std::string path;   // as it was received: not decoded, before the first question mark
  std::string query;  // as it was received, behind the first question mark
  HttpHeaders headers;
  uint64_t body_bytes = 0;
};

struct ViewResponse {
  int status = 200;
  HttpHeaders headers;
  std::string body;  // where no file is open
  OpenFile file;     // of which `bytes` bytes from `offset` on are the body
  uint64_t offset = 0, bytes = 0;
};

/// The values of all headers of that name, which is compared without regard to case.
std::vector<std::string_view> header_values(const HttpHeaders& headers, std::string_view name);

/// Whether the request has one Host header, which names localhost, 127.0.0.1, [::1] or one of
/// `allowed`, with any port: a tunnel may have another one.
bool is_host_allowed(const ViewRequest& request, const std::vector<std::string>& allowed);

/// Whether each Origin header names the server that the Host header does. A request without one
/// passes unless it changes something: browsers send Origin with each POST.
bool is_origin_allowed(const ViewRequest& request);

/// 128 random bits of the kernel as 32 hexadecimal digits. Errors: std::runtime_error where the
/// kernel has none.
std::string make_view_token();

/// Whether both are equal, in a time that depends on their lengths only.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// Browsers send a cookie to all ports of a host, so each server has a name of its own.
std::string view_cookie_name(uint16_t port);

/// Whether one cookie of a `Cookie` header has the name and the value.
bool cookies_have(std::string_view header, std::string_view name, std::string_view value);

}  // namespace tessera
