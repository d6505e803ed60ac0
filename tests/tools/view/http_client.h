// A socket of a test, connected to a server on this machine.
#pragma once
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <cstdint>
#include <string>

#include "tools/view/served_file.h"

namespace tessera::testing {

/// A connection of which all is read until the server closes it, or nothing comes for
/// `milliseconds`.
class HttpClient {
 public:
  explicit HttpClient(uint16_t port, long milliseconds = 10'000)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval limit{milliseconds / 1000, milliseconds % 1000 * 1000};
    ::setsockopt(socket_.descriptor(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    EXPECT_EQ(::connect(socket_.descriptor(), reinterpret_cast<const sockaddr*>(&address),
                        sizeof address),
              0);
  }
  void send(const std::string& text) const {
    ::send(socket_.descriptor(), text.data(), text.size(), MSG_NOSIGNAL);
  }
  /// At most 4096 bytes; "" at the end.
  std::string read_some() const {
    char part[4096];
    const ssize_t read = ::recv(socket_.descriptor(), part, sizeof part, 0);
    return {part, read > 0 ? size_t(read) : 0};
  }
  std::string read_all() const {
    std::string text;
    for (std::string part; !(part = read_some()).empty();) text += part;
    return text;
  }

 private:
  OpenFile socket_;
};

}  // namespace tessera::testing
