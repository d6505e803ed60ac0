// Trains a long clip window by window in one folder (tools/session/windows_folder.h). Any number of
// programs may do so in the same folder, on one machine or several: each takes what no other has in
// work, and what a killed one has left is resumed.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "tools/cli/train_arguments.h"
#include "tools/session/clock/time_limit.h"
#include "tools/session/windows_folder.h"

namespace tessera {

struct WindowsRequest {
  std::filesystem::path scene, root;
  TrainArguments arguments;
  int64_t count = 2;
  std::string reason;      // why so many: said when the clip is cut
  int64_t gpus = 1;        // cards that train windows at once
  bool overwrite = false;  // what the folder holds of another request is kept as ROOT.1
  double time_limit = 0;   // seconds by the stopwatch; 0: none
  Stopwatch stopwatch = running_stopwatch();
};

/// Returns when all windows are trained, by this program or another, or when it is stopped. What
/// windows_result has, with `left` (it was stopped) and `continued` (whether an earlier program had
/// begun). Errors: InputError: the folder holds what was made for another request; a window that
/// cannot be trained, after all others have been.
nlohmann::json train_windows(const WindowsRequest& request);

}  // namespace tessera
