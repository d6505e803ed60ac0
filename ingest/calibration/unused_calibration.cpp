// Judges by names and by the first bytes; what may be readable is read.
#include "ingest/calibration/unused_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "ingest/calibration/calibration.h"
#include "ingest/images/listing.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// By its name where it may be one of ours, by its words where it is not.
bool seems_calibration(const fs::path& file) {
  const std::string name = lower_case(file.filename().string());
  const std::string extension = lower_case(file.extension().string());
  if (name.starts_with('.') || name.starts_with("transforms")) return false;
  for (const char* part : {"calib", "camera", "extri", "intri", "pose", "rig.", "rig_"})
    if (kind_of_file(file) == FileKind::kTable && name.find(part) != std::string::npos) return true;
  if (extension == ".json" || extension == ".yml" || extension == ".yaml") return false;
  return extension == ".nvm" || name == "bundle.out" || speaks_of_cameras(file);
}

bool is_readable(const fs::path& file) {
  try {
    read_calibration(file);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

void note_unused_calibration(const fs::path& capture, const std::vector<fs::path>& known,
                             std::vector<std::string>& warnings) {
  std::vector<std::string> readable, others;
  std::optional<fs::path> example;
  std::vector<fs::path> files;
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(capture, unreachable))
    if (entry.is_regular_file(unreachable)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  const EasyMocapFiles pair = find_easymocap(capture);
  for (const fs::path& file : files) {
    const bool is_known = std::any_of(known.begin(), known.end(), [&](const fs::path& other) {
      return other.lexically_normal() == file.lexically_normal();
    });
    const bool has_sibling = file == pair.extri;  // named with the other one
    if (is_known || has_sibling || !seems_calibration(file)) continue;
    const bool can_read = is_readable(file);
    if (can_read && !example) example = file;
    (can_read ? readable : others).push_back(file.filename().string());
  }
  if (readable.empty() && others.empty()) return;
  std::string line = capture.string() + ":";
  if (example)
    line +=
        fmt::format(" {} {} not used; to take the poses from there, pass --poses {}",
                    listed_names(readable), readable.size() == 1 ? "is" : "are", example->string());
  if (!others.empty())
    line += fmt::format("{} {} {} not read; poses are read from {}", example ? ";" : "",
                        listed_names(others), others.size() == 1 ? "is" : "are", kCalibrationForms);
  warnings.push_back(line);
}

}  // namespace tessera
