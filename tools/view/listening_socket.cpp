// Resolves the address, binds and listens.
#include "tools/view/listening_socket.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Addresses addresses_of(const std::string& host, uint16_t port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int failure = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (failure != 0)
    throw InputError(
        fmt::format("view: --host '{}' is no address of this machine ({}); 127.0.0.1 "
                    "is reached from this machine alone, 0.0.0.0 from all",
                    host, ::gai_strerror(failure)));
  return {found, &::freeaddrinfo};
}

void describe(const sockaddr* address, ListeningSocket& result) {
  if (address->sa_family == AF_INET6) {
    const auto* const ipv6 = reinterpret_cast<const sockaddr_in6*>(address);
    result.port = ntohs(ipv6->sin6_port);
    result.is_loopback = IN6_IS_ADDR_LOOPBACK(&ipv6->sin6_addr);
    result.is_any = IN6_IS_ADDR_UNSPECIFIED(&ipv6->sin6_addr);
    result.is_ipv6 = true;
  } else {
    const auto* const ipv4 = reinterpret_cast<const sockaddr_in*>(address);
    const uint32_t number = ntohl(ipv4->sin_addr.s_addr);
    result.port = ntohs(ipv4->sin_port);
    result.is_loopback = number >> 24 == 127;
    result.is_any = number == INADDR_ANY;
  }
}

}  // namespace

ListeningSocket listen_on(const std::string& host, uint16_t port) {
  const Addresses addresses = addresses_of(host, port);
  const addrinfo& address = *addresses;
  ListeningSocket result;
  result.socket =
      OpenFile(::socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int socket = result.socket.descriptor(), on = 1;
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  auto* const name = reinterpret_cast<sockaddr*>(&bound);
  // SO_REUSEADDR: connections of a view that has ended do not keep its port
  if (!result.socket.is_open() ||
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
      ::bind(socket, address.ai_addr, address.ai_addrlen) != 0 ||
      ::listen(socket, SOMAXCONN) != 0 || ::getsockname(socket, name, &size) != 0)
    throw InputError(
        fmt::format("view: cannot listen on --host {} --port {} ({}); --port 0 takes "
                    "a free port",
                    host, port, std::strerror(errno)));
  describe(name, result);
  return result;
}

}  // namespace tessera
