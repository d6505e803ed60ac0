// Counts of the cameras that see each sample point.
#include "ingest/checks/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "ingest/checks/rig_spacing.h"
#include "kernels/base/camera_rig.h"

namespace tessera {
namespace {

constexpr size_t kSamples = 4000;
constexpr double kMuchUnseen = 0.25;  // a quarter of the scene without a second view
constexpr double kMuchAlone = 0.4;

glm::dvec3 axis_of(const Camera& camera) {
  return glm::transpose(camera.cam_from_world)[2];
}

std::vector<glm::dvec3> grid_samples(const std::vector<Station>& stations, size_t most) {
  std::vector<Camera> cameras;
  for (const Station& station : stations) cameras.push_back(station.camera);
  const glm::dvec3 focus = make_camera_rig(cameras).focus;
  const size_t each = std::max<size_t>(1, most / (3 * std::max<size_t>(1, stations.size())));
  const int side = std::max(2, int(std::sqrt(double(each))));
  std::vector<glm::dvec3> samples;
  for (const Station& station : stations) {
    const Camera& camera = station.camera;
    const double distance = glm::length(focus - camera.position());
    for (const double depth : {0.5 * distance, distance, 2 * distance})
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
          const glm::dvec3 ray{((i + 0.5) / side * camera.width - camera.cx) / camera.fl_x,
                               ((j + 0.5) / side * camera.height - camera.cy) / camera.fl_y, 1};
          samples.push_back(camera.position() +
                            glm::transpose(camera.cam_from_world) * (ray * depth));
        }
  }
  return samples;
}

std::vector<std::vector<bool>> visibility(const std::vector<Station>& stations,
                                          const std::vector<glm::dvec3>& samples) {
  std::vector<std::vector<bool>> seen(stations.size(), std::vector<bool>(samples.size()));
  double x = 0, y = 0;
  for (size_t s = 0; s < stations.size(); ++s)
    for (size_t p = 0; p < samples.size(); ++p)
      seen[s][p] = project_into(stations[s].camera, samples[p], x, y);
  return seen;
}

void judge(CoverageCheck& check) {
  const size_t cameras = check.name.size();
  const double weak = check.seen_by_none + check.seen_by_one;
  const bool warn = weak > kMuchUnseen;
  check.findings.push_back(
      {warn ? Severity::kWarning : Severity::kInfo, "coverage", "",
       fmt::format("{:.0f} % of {} are seen by fewer than 2 training cameras", 100 * weak,
                   check.by_cloud ? "the cloud's points" : "the view volume"),
       warn ? "its depth is undetermined: add cameras there, or crop the scene to what they share"
            : ""});
  size_t named = 0, more = 0;
  for (size_t s = 0; s < cameras; ++s)
    if (check.alone[s] > kMuchAlone) {
      if (++named > kMostNamed)
        ++more;
      else
        check.findings.push_back(
            {Severity::kWarning, "coverage", check.name[s],
             fmt::format("{:.0f} % of its view is seen by no other camera", 100 * check.alone[s]),
             "turn it towards the others' view or add a camera beside it"});
    }
  if (more > 0)
    check.findings.push_back({Severity::kWarning, "coverage", "",
                              fmt::format("{} more cameras see mostly what no other sees", more),
                              "see the table of --json"});
}

}  // namespace

std::vector<glm::dvec3> view_samples(const Scene& scene, const std::vector<Station>& stations,
                                     size_t most) {
  constexpr size_t kLeast = 100;
  const size_t count = scene.points.position.size();
  if (count < kLeast) return grid_samples(stations, most);
  std::vector<glm::dvec3> samples;
  const size_t step = std::max<size_t>(1, count / most);
  for (size_t i = 0; i < count; i += step) samples.emplace_back(scene.points.position[i]);
  return samples;
}

std::vector<std::vector<int>> overlapping_stations(const std::vector<Station>& stations,
                                                   const std::vector<glm::dvec3>& samples,
                                                   size_t most) {
  const auto seen = visibility(stations, samples);
  std::vector<std::vector<int>> best(stations.size());
  for (size_t a = 0; a < stations.size(); ++a) {
    // Cameras at a small angle match best, so each shared sample counts by the cosine of the axes.
    std::vector<std::pair<double, int>> scores;
    for (size_t b = 0; b < stations.size(); ++b) {
      const glm::dvec3 baseline = stations[a].camera.position() - stations[b].camera.position();
      if (a == b || glm::length(baseline) < 1e-9) continue;
      int64_t shared = 0;
      for (size_t p = 0; p < samples.size(); ++p) shared += seen[a][p] && seen[b][p];
      const double facing = glm::dot(axis_of(stations[a].camera), axis_of(stations[b].camera));
      if (shared > 0 && facing > 0.3) scores.push_back({-double(shared) * facing, int(b)});
    }
    std::sort(scores.begin(), scores.end());
    for (size_t k = 0; k < std::min(most, scores.size()); ++k) best[a].push_back(scores[k].second);
  }
  return best;
}

CoverageCheck check_coverage(const Scene& scene) {
  const std::vector<Station> stations = training_stations(scene);
  const std::vector<glm::dvec3> samples = view_samples(scene, stations, kSamples);
  const auto seen = visibility(stations, samples);
  std::vector<int> cameras(samples.size());
  for (const auto& of_station : seen)
    for (size_t p = 0; p < samples.size(); ++p) cameras[p] += of_station[p];
  CoverageCheck check;
  const bool held_out = !scene.is_static && !scene.split_indices(Split::kTest).empty();
  const bool moves = !scene.is_static &&  // one camera, which has as many stations as frames
                     std::all_of(stations.begin(), stations.end(),
                                 [](const Station& station) { return station.frames.size() < 2; });
  const std::optional<Finding> expected = expected_views(stations, held_out);
  if (expected && !moves) check.findings.push_back(*expected);
  check.by_cloud = scene.points.position.size() >= 100;
  const double count = double(samples.size());
  check.seen_by_none = double(std::count(cameras.begin(), cameras.end(), 0)) / count;
  check.seen_by_one = double(std::count(cameras.begin(), cameras.end(), 1)) / count;
  for (size_t s = 0; s < stations.size(); ++s) {
    int64_t seen_cells = 0, alone = 0;
    for (size_t p = 0; p < samples.size(); ++p)
      if (seen[s][p]) {
        ++seen_cells;
        alone += cameras[p] == 1;
      }
    check.name.push_back(stations[s].name);
    check.alone.push_back(seen_cells == 0 ? 0 : double(alone) / double(seen_cells));
  }
  judge(check);
  return check;
}

}  // namespace tessera
