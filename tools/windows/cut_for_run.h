// The cut of a clip for a run folder: the one that is there, else by the memory of this machine.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "recon4d/options/train_options.h"
#include "tools/windows/window_choice.h"

namespace tessera {

/// choose_windows of --windows and the scene in that folder, for this machine; `none` reads
/// nothing. A clip in which nothing moves (`motion`) is trained as a whole. Where `run` holds a
/// training on `files` (kSceneFiles) already, `auto` is its cut: another machine has other memory,
/// which `programs` share. Errors: InputError: a length where nothing moves, too.
WindowChoice cut_for_run(const std::string& windows, const std::filesystem::path& scene,
                         const std::string& files, Motion motion, const std::filesystem::path& run,
                         int64_t programs);

}  // namespace tessera
