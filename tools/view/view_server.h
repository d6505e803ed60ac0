// Serves the responses of answer() over HTTP from one thread: at most 32 connections, while further
// ones wait; each has 32 kB for its headers and is closed after 20 s without traffic.
#pragma once
#include <memory>

#include "tools/view/answer.h"
#include "tools/view/listening_socket.h"

namespace tessera {

/// Errors: InputError where the program was built without libmicrohttpd.
void require_view_server();

class ViewServer {
 public:
  /// Serves from now on. The port of `state` is that of the socket. Errors: as
  /// require_view_server(); std::runtime_error where no thread can be started.
  ViewServer(ViewState state, ListeningSocket socket);
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;
  /// Closes all connections; answers in progress are sent before, for at most 2 s.
  ~ViewServer();

 private:
  struct Daemon;
  std::unique_ptr<Daemon> daemon_;
};

}  // namespace tessera
