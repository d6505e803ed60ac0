// Writes the file of a long clip window by window: blocks go to the folder as they are made.
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "static3d/tessera4d/block_sets.h"
#include "static3d/tessera4d/windowed_file.h"

namespace tessera {

WindowedWriter::WindowedWriter(std::filesystem::path folder, const GaussianModel& fixed,
                               const TimeAxis& clip, std::vector<FileWindow> windows,
                               const Tessera4dOptions& options)
    : folder_(std::move(folder)),
      rules_(rules_of(fixed, clip)),
      blocks_(
          rules_, options, box_of_means({fixed.static_set.values()}),
          [this](const std::string& name, const std::string& bytes) {
            write_text_file(folder_ / name, bytes);
            bytes_ += int64_t(bytes.size());
          },
          windows),
      added_(windows.size(), false) {
  check(wrong_windows(windows).empty(), "WindowedWriter: windows that do not tile the clip");
  check(fixed.nodes.empty(), "WindowedWriter: a static set with motion nodes");
  make_folder(folder_);
  std::filesystem::remove(folder_ / kTessera4dManifest);
  blocks_.add_static(fixed.static_set, fixed.nodes);
}

void WindowedWriter::add(int window, const GaussianModel& model) {
  check(window >= 0 && size_t(window) < added_.size() && !added_[size_t(window)],
        "WindowedWriter: a window that is not there, or added before");
  check(model.drawing.sh_degree <= rules_.drawing.sh_degree,
        "WindowedWriter: a window of a higher SH degree than the static set's");
  added_[size_t(window)] = true;
  blocks_.add_dynamic(model, window);
}

Tessera4dWritten WindowedWriter::finish() {
  for (const bool added : added_) check(added, "WindowedWriter: finished without some window");
  const std::string manifest = to_json(blocks_.manifest(), rules_).dump() + "\n";
  write_text_file(folder_ / kTessera4dManifest, manifest);
  return {blocks_.counts(), blocks_.manifest().peak(), bytes_ + int64_t(manifest.size())};
}

}  // namespace tessera
