// The answer of `tessera view` to a request, without sockets: tests and the fuzzer call the same
// function as the transport (view_server.h).
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/view/view_request.h"

namespace tessera {

/// What a training that is watched adds to the addresses. Called from the server's thread, and none
/// of them throws or waits for the training.
struct LiveHooks {
  /// JSON for `GET /api/state?seen=N`; N: number of the newest snapshot that the page shows.
  std::function<std::string(int64_t seen)> state;
  /// JSON of what its log has so far, for `GET /api/report`.
  std::function<std::string()> report;
  /// PNG of the truth of a held-out view, for `GET /api/truth?view=I`; "": there is none such.
  std::function<std::string(int64_t view)> truth;
  /// Asks the training to save and leave, for `POST /api/stop`; false: none is running.
  std::function<bool()> stop;
};

/// The state of the server; constant while it runs.
struct ViewState {
  OpenFile folder;                         // whose files are served
  std::string token;                       // make_view_token()
  uint16_t port = 0;                       // of the server, in the name of its cookie
  std::vector<std::string> allowed_hosts;  // beside localhost, 127.0.0.1 and [::1]
  std::string start = "/";                 // path of the page that `/` leads to
  std::string run = "{}";                  // JSON for /api/run
  std::optional<LiveHooks> live;           // of a training that is watched
  std::string live_page, player_page;      // HTML for /live and /api/player
};

constexpr uint64_t kMostBodyBytes = 4096;  // of a request

/// Checks, in this order: Host (421), method (405), Origin (403), size of the body (413), token
/// (403). Then GET and HEAD get `/api/run`, of a training that is watched the values of LiveHooks,
/// or a file of the folder (200, 206, 416), or 404. Only
/// `/api/stop` takes a POST (202, 409; else 405).
/// `/?token=T` with the right token sets a cookie, which stands for the token from then on, and
/// leads to the same address without it (303).
ViewResponse answer(const ViewRequest& request, const ViewState& state);

}  // namespace tessera
