// What a training that is watched adds to the addresses of `tessera view`.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace tessera {

/// Called from the server's thread, and none of them throws or waits for the training.
struct LiveHooks {
  /// JSON for `GET /api/state?seen=N`; N: number of the newest snapshot that the page shows.
  std::function<std::string(int64_t seen)> state;
  /// HTML of its curves, for `GET /api/charts`; "": there are none yet.
  std::function<std::string()> charts;
  /// PNG of the truth of a held-out view, for `GET /api/truth?view=I`; "": there is none such.
  std::function<std::string(int64_t view)> truth;
  /// Asks the training to save and leave, for `POST /api/stop`; false: none is running.
  std::function<bool()> stop;
  /// Starts it from its checkpoint, for `POST /api/resume`; false: it runs, or has none.
  std::function<bool()> resume;
};

}  // namespace tessera
