// Trains a long clip in one folder (tools/session/windows_folder.h) as a list of jobs: what stands
// still in it, its training, and the training of each window.
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
  std::string files;  // the content of the scene, for kSceneFiles
  int64_t count = 2;
  std::string reason;      // why so many: said when the clip is cut
  int64_t gpus = 1;        // cards that train windows at once
  bool overwrite = false;  // what the folder holds of another request is kept as ROOT.1
  double time_limit = 0;   // seconds by the stopwatch; 0: none
  Stopwatch stopwatch = running_stopwatch();
};

/// Returns when all windows are trained, or it is stopped: what windows_result has, with `left` (it
/// was stopped) and `continued` (whether an earlier program had begun). Limits of size are those of
/// the clip: the static set has half at most, and the windows share what it leaves. Errors:
/// InputError: the folder holds what was made for another request; another program trains in it;
/// what a window's training refuses, after all others have been trained.
nlohmann::json train_windows(const WindowsRequest& request);

}  // namespace tessera
