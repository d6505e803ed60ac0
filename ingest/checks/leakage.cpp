// Finds equal files, equal views and equal cameras across the splits. Similar images are not
// compared.
#include "ingest/checks/leakage.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <map>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

bool trains(const Frame& frame) {
  return frame.split == Split::kTrain;
}

/// Index of a training image with the same bytes, for each held-out one that has such.
std::map<size_t, size_t> equal_images(const Scene& scene,
                                      const std::vector<std::filesystem::path>& images) {
  std::map<uintmax_t, std::vector<size_t>> of_size;
  for (size_t i = 0; i < images.size(); ++i)
    if (!images[i].empty()) of_size[std::filesystem::file_size(images[i])].push_back(i);
  std::map<size_t, size_t> equal;
  for (const auto& [size, places] : of_size) {
    std::map<std::string, size_t> training;
    bool held_out = false;
    for (const size_t i : places) held_out = held_out || !trains(scene.frames[i]);
    if (!held_out || places.size() < 2) continue;
    for (const size_t i : places)
      if (trains(scene.frames[i])) training.emplace(read_text_file(images[i]), i);
    for (const size_t i : places) {
      if (trains(scene.frames[i]) || training.empty()) continue;
      const auto found = training.find(read_text_file(images[i]));
      if (found != training.end()) equal[i] = found->second;
    }
  }
  return equal;
}

bool same_pose(const Camera& a, const Camera& b) {
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    largest = std::max(largest, glm::length(a.cam_from_world[c] - b.cam_from_world[c]));
  const double scale = 1 + glm::length(a.translation);
  return largest < 1e-6 && glm::length(a.translation - b.translation) < 1e-6 * scale;
}

/// First training frame of the same timestep and pose for each held-out frame that has such.
std::map<size_t, size_t> equal_views(const Scene& scene) {
  std::map<int64_t, std::vector<size_t>> training;  // by timestep
  for (size_t i = 0; i < scene.frames.size(); ++i)
    if (trains(scene.frames[i])) training[scene.frames[i].timestep].push_back(i);
  std::map<size_t, size_t> equal;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const auto timestep = training.find(scene.frames[i].timestep);
    if (trains(scene.frames[i]) || timestep == training.end()) continue;
    for (const size_t other : timestep->second)
      if (same_pose(scene.frames[i].camera, scene.frames[other].camera)) {
        equal[i] = other;
        break;
      }
  }
  return equal;
}

void report(const Scene& scene, const std::map<size_t, size_t>& equal, const char* what,
            Findings& findings) {
  if (equal.empty()) return;
  const auto& [held_out, training] = *equal.begin();
  findings.push_back({Severity::kError, "leakage", scene.frames[held_out].camera_name,
                      fmt::format("{} held-out frame{} {} of a training frame: {} and {}",
                                  equal.size(), equal.size() == 1 ? " has" : "s have", what,
                                  scene.frames[held_out].name, scene.frames[training].name),
                      "remove one of the two from its split; scores would count what was trained"});
}

}  // namespace

Leakage check_leakage(const Scene& scene, const std::vector<std::filesystem::path>& images) {
  check(images.size() == scene.frames.size(), "check_leakage: an image a frame");
  Leakage leakage;
  Fnv1a manifest;
  for (const Frame& frame : scene.frames) {
    ++(trains(frame) ? leakage.training_frames : leakage.held_out_frames);
    if (trains(frame)) manifest.add(frame.name + "\n");
  }
  leakage.training_manifest = manifest.hex();
  const std::map<size_t, size_t> files = equal_images(scene, images), views = equal_views(scene);
  leakage.same_images = int64_t(files.size());
  leakage.same_views = int64_t(views.size());
  report(scene, files, "the very image", leakage.findings);
  report(scene, views, "pose and timestep", leakage.findings);
  leakage.findings.push_back(
      {Severity::kInfo, "leakage", "",
       fmt::format("{} training frames (manifest {}), {} held out", leakage.training_frames,
                   leakage.training_manifest, leakage.held_out_frames),
       ""});
  return leakage;
}

}  // namespace tessera
