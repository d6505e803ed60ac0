// The token by which a browser proves that its user was given the address that `tessera view`
// prints: other users of the same machine can reach the port, but do not have the token.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace tessera {

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
