// The socket on which `tessera view` accepts connections.
#pragma once
#include <cstdint>
#include <string>

#include "tools/view/served_file.h"

namespace tessera {

struct ListeningSocket {
  OpenFile socket;
  uint16_t port = 0;         // the one it got
  bool is_loopback = false;  // only this machine can reach it
  bool is_any = false;       // all addresses of this machine
  bool is_ipv6 = false;
};

/// `host`: an address of this machine or a name of one; port 0: a free one. Errors: InputError
/// naming the option and the reason.
ListeningSocket listen_on(const std::string& host, uint16_t port);

}  // namespace tessera
