// The Tessera 4D file of a long clip: one static set, and a dynamic set for each window in a time
// of its own. It is written and read window by window, so that memory does not grow with the clip.
// Source: docs/reference/tessera4d.md, section 6.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "static3d/tessera4d/blocks_writer.h"
#include "static3d/tessera4d/container.h"
#include "static3d/tessera4d/tessera4d.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

/// What has been written.
struct Tessera4dWritten : Tessera4dCounts {
  int64_t peak = 0;   // the most Gaussians that are drawn at a time
  int64_t bytes = 0;  // of manifest and blocks
};

class WindowedWriter {
 public:
  /// `fixed`: the static set, without motion nodes, and how all Gaussians are drawn; `clip`: of the
  /// whole clip. Static blocks are written at once, and a manifest that the folder has goes.
  /// Outliers are told by the means of the static set. Errors: InputError: the folder; a segment of
  /// no length.
  WindowedWriter(std::filesystem::path folder, const GaussianModel& fixed, const TimeAxis& clip,
                 std::vector<FileWindow> windows, const Tessera4dOptions& options);

  /// Writes the blocks of a window: the dynamic set of `model`, in the window's time. Gaussians
  /// that are not drawn within its core are left out and counted. Each window once, in any order;
  /// an SH degree above that of `fixed` is a bug of the caller.
  void add(int window, const GaussianModel& model);
  /// Writes the manifest, when all windows have been added.
  Tessera4dWritten finish();

  WindowedWriter(const WindowedWriter&) = delete;
  WindowedWriter& operator=(const WindowedWriter&) = delete;

 private:
  std::filesystem::path folder_;
  GaussianModel rules_;
  int64_t bytes_ = 0;
  BlocksWriter blocks_;
  std::vector<bool> added_;  // [windows]
};

/// A file as parts that are loaded one at a time: its windows, or one part where it has none.
class Tessera4dParts {
 public:
  /// Reads the manifest. Errors: InputError naming the file, what is wrong, the remedy.
  explicit Tessera4dParts(const std::filesystem::path& path);

  const Tessera4dManifest& manifest() const { return container_.manifest(); }
  /// At least one.
  const std::vector<FileWindow>& windows() const { return windows_; }
  /// Time of the whole clip.
  const TimeAxis& clip() const { return container_.rules().time_axis; }
  /// Of manifest and blocks.
  int64_t bytes() const { return container_.bytes(); }
  /// The static set and the window's dynamic set, with the window's time as its time axis. Static
  /// blocks are read once. Errors: as above.
  GaussianModel load(int window);
  /// The static set alone, in the light of no window, with the time axis of the clip. Errors: as
  /// above.
  GaussianModel load_static();
  /// What was left out of that which has been loaded.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  Tessera4dContainer container_;
  std::vector<FileWindow> windows_;
  std::vector<std::string> warnings_;
  std::optional<GaussianModel> fixed_;
};

/// From a folder or a single file, of any version.
Tessera4dParts open_tessera4d(const std::filesystem::path& path);

}  // namespace tessera
