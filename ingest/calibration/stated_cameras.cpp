// Reads the candidates in their order and matches each with the clips.
#include "ingest/calibration/stated_cameras.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/calibration/calibration.h"
#include "ingest/calibration/unused_calibration.h"
#include "ingest/calibration/view_matching.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/images/image_names.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRowFile = "poses_bounds.npy";

/// Whether numbers at the end of names ascend as the names do.
bool counts_as_sorted(const std::vector<std::string>& names) {
  std::optional<NumberedName> before;
  for (const std::string& name : names) {
    const auto now = parse_stem(name);
    if (now && before && now->camera == before->camera && now->number < before->number)
      return false;
    before = now;
  }
  return true;
}

/// Errors: InputError: no clip has a camera.
StatedCameras matched(Calibration calibration, const std::vector<std::string>& clips,
                      std::vector<std::string>& warnings) {
  StatedCameras stated;
  stated.path = calibration.path;
  MatchedViews match;
  if (calibration.by_row) {
    if (calibration.cameras.size() != clips.size())
      throw InputError(fmt::format(
          "{}: has {} rows, the capture {} cameras ({}); remove those without a pose or add the "
          "missing ones",
          calibration.path.string(), calibration.cameras.size(), clips.size(),
          listed_names(clips)));
    for (size_t i = 0; i < clips.size(); ++i) match.camera.emplace_back(i);
    if (!counts_as_sorted(clips))
      warnings.push_back(fmt::format(
          "{}: its rows are taken in the order of letters, {}, which is not that of their numbers; "
          "if the rows are in that of the numbers, call the cameras 01, 02 … with as many digits",
          calibration.path.string(), listed_names(clips)));
  } else {
    match = match_views(calibration.cameras, clips);
  }
  if (!match.refusal.empty())
    throw InputError(fmt::format("{}: {}; call the cameras as the clips, or number both alike",
                                 calibration.path.string(), match.refusal));
  for (size_t i = 0; i < clips.size(); ++i) {
    std::optional<RigCamera>& camera = stated.cameras.emplace_back();
    if (!match.camera[i]) continue;
    camera = calibration.cameras[*match.camera[i]];
    camera->name = clips[i];
  }
  std::vector<std::string> without_clip;
  for (size_t k = 0; k < calibration.cameras.size(); ++k) {
    stated.stated_names.push_back(calibration.cameras[k].name);
    const bool is_used =
        std::find(match.camera.begin(), match.camera.end(), k) != match.camera.end() ||
        match_views({calibration.cameras[k]}, clips).refusal.empty();  // several images of a camera
    if (!is_used) without_clip.push_back(stated.stated_names.back());
  }
  if (!without_clip.empty())
    warnings.push_back(fmt::format("{}: the capture has no clip of {}; it has {}",
                                   calibration.path.string(), listed_names(without_clip),
                                   listed_names(clips)));
  stated.points = std::move(calibration.points);
  stated.origin = calibration.origin;
  stated.by_row = calibration.by_row;
  stated.files = std::move(calibration.files);
  stated.notes = std::move(calibration.notes);
  warnings.insert(warnings.end(), calibration.warnings.begin(), calibration.warnings.end());
  return stated;
}

/// The model in the first of the folders of timesteps, which have one each.
std::vector<fs::path> first_of_timesteps(const fs::path& capture) {
  std::vector<fs::path> folders, found;
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(capture, unreachable))
    if (entry.is_directory(unreachable)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& folder : folders)
    if (found.empty()) found = colmap_models_in(folder);
  return found;
}

/// What may be read without being named, the first before the others.
std::vector<fs::path> candidates_in(const fs::path& capture, bool models_only) {
  std::vector<fs::path> found = colmap_models_in(capture);
  if (found.empty()) found = first_of_timesteps(capture);
  if (models_only) return found;
  if (const fs::path pair = find_easymocap(capture).intri; !pair.empty()) found.push_back(pair);
  return found;
}

/// Errors: InputError: it cannot be read, or one of `wanted` has no camera.
StatedCameras read_candidate(const fs::path& capture, const fs::path& candidate,
                             const std::vector<std::string>& clips,
                             const std::vector<std::string>& wanted,
                             std::vector<std::string>& warnings) {
  Calibration calibration = read_calibration(candidate);
  const std::string form = calibration.form;
  std::vector<std::string> said;
  StatedCameras stated = matched(std::move(calibration), clips, said);
  std::vector<std::string> missing;
  for (const std::string& name : wanted) {
    const auto clip = std::find(clips.begin(), clips.end(), name);
    if (clip != clips.end() && !stated.cameras[size_t(clip - clips.begin())])
      missing.push_back(name);
  }
  if (!missing.empty())
    throw InputError(fmt::format("{}: has no camera for {}; it has {}", candidate.string(),
                                 listed_names(missing), listed_names(stated.stated_names)));
  const std::string place = candidate.lexically_relative(capture).generic_string();
  stated.notes.push_back(fmt::format("poses of {} cameras from {} ({})", wanted.size(),
                                     place.empty() || place == "." ? capture.string() : place,
                                     form));
  warnings.insert(warnings.end(), said.begin(), said.end());
  return stated;
}

}  // namespace

std::optional<StatedCameras> stated_cameras(const fs::path& capture, const PoseSource& source,
                                            const std::vector<std::string>& clips,
                                            const std::vector<std::string>& wanted,
                                            std::vector<std::string>& warnings) {
  const bool is_found = source.kind == PoseSource::kFound;
  const bool of_rows = source.kind == PoseSource::kN3dv || source.kind == PoseSource::kLlff;
  if (of_rows || (is_found && fs::exists(capture / kRowFile))) {
    StatedCameras rows = matched(read_calibration(capture / kRowFile), clips, warnings);
    if (is_found) note_unused_calibration(capture, rows.files, warnings);
    return rows;
  }
  if (source.kind == PoseSource::kCameras)
    return matched(read_calibration(source.cameras), clips, warnings);
  std::optional<StatedCameras> found;
  std::vector<fs::path> seen;  // that is used, or warned of
  for (const fs::path& candidate : candidates_in(capture, !is_found)) try {
      found = read_candidate(capture, candidate, clips, wanted.empty() ? clips : wanted, warnings);
      seen.insert(seen.end(), found->files.begin(), found->files.end());
      break;
    } catch (const InputError& error) {
      warnings.push_back(fmt::format("{}: this calibration is not used", error.what()));
      seen.push_back(candidate);
    }
  if (is_found) note_unused_calibration(capture, seen, warnings);
  return found;
}

}  // namespace tessera
