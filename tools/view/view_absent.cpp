// Replaces the server in a build without libmicrohttpd: an error that names what to install.
#include "kernels/base/errors.h"
#include "tools/view/view_server.h"

namespace tessera {

struct ViewServer::Daemon {};

void require_view_server() {
  throw InputError(
      "view: this program was built without libmicrohttpd; install libmicrohttpd-dev and build "
      "again, or export a page that opens with a double click: tessera export RUN -o DIR --format "
      "html");
}

ViewServer::ViewServer(ViewState, ListeningSocket) {
  require_view_server();
}
ViewServer::~ViewServer() = default;

}  // namespace tessera
