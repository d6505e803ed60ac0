// The folder of a long clip that is trained window by window. Its windows.json says how the clip is
// cut; static_scene/ is what stands still in it, as a prepared scene, static/ the run of its
// training, whose Gaussians all windows share, and windows/0000/ the run of the first window.
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ingest/clocks/windows.h"
#include "ingest/scene.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

/// How a clip is cut.
struct WindowsPlan {
  std::string scene;  // a whole path
  int64_t overlap = Window().overlap;
  TimeAxis clip;
  std::vector<FileWindow> windows;
  nlohmann::json request;  // that they are made for; null by a version that did not record it

  Window window(int64_t index) const { return {index, int64_t(windows.size()), overlap}; }
};

/// Equal windows of a clip of so many timesteps, whose frames `scene` lists (without pixels).
/// Borders lie midway between two timesteps. Errors: InputError: as range_of.
std::vector<FileWindow> cut_clip(const Scene& scene, int64_t count, int64_t overlap);

struct WindowsFolder {
  std::filesystem::path root;

  std::filesystem::path plan_file() const { return root / "windows.json"; }
  std::filesystem::path static_scene() const { return root / "static_scene"; }
  std::filesystem::path static_run() const { return root / "static"; }
  std::filesystem::path window_run(int64_t index) const;
  /// Whether a clip has been cut here.
  bool exists() const { return std::filesystem::exists(plan_file()); }
  /// Errors: InputError: missing, damaged, of a newer version.
  WindowsPlan read() const;
  void write(const WindowsPlan& plan) const;
  /// Whether the training in that run folder is complete: it leaves its checkpoint behind then.
  static bool is_finished(const std::filesystem::path& run);
  /// Windows whose training is not complete, from 1 as people count.
  std::vector<int64_t> missing(const WindowsPlan& plan) const;
};

/// Errors: InputError naming windows whose training is not complete, and the command that goes on.
void require_all_windows(const WindowsFolder& folder, const WindowsPlan& plan);

/// The folder of windows that `path` means: itself, or the one inside where it is an OUT of
/// `tessera run`. Its `exists()` is false where there is none.
WindowsFolder windows_folder_of(const std::filesystem::path& path);

}  // namespace tessera
