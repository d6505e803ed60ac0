// Writes the frames of a prepared scene, or of a window of it, as image files: for programs that
// read Nerfstudio's folders, and for builds without FFmpeg.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>

#include "ingest/clocks/windows.h"

namespace tessera {

/// A prepared scene in `out` that loads as the one in `folder` does with that window. `progress`:
/// frames done, of how many; may throw to stop. Returns the number of frames. Errors: InputError:
/// as load_scene; `folder` is no prepared scene; `out` cannot be written, or holds something else.
int64_t unpack_scene(const std::filesystem::path& folder, const std::optional<Window>& window,
                     const std::filesystem::path& out,
                     const std::function<void(int64_t, int64_t)>& progress);

}  // namespace tessera
