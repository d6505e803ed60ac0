// What: medians over matches, pairs and cameras; thresholds by the image's diagonal.
// Not: matching. A camera that is wrong spoils one pair of each neighbour: the median over pairs
//      leaves the neighbours out of it.
#include "ingest/checks/pose_residual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr size_t kLeastMatches = 12;    // of a pair
constexpr int64_t kLeastFeatures = 60;  // of an image
constexpr double kSuspicious = 0.0015;  // of the diagonal: 0.9 pixels at 480 × 360
constexpr double kWrong = 0.0035;       // of the diagonal: 2.1 pixels at 480 × 360

double diagonal(const Camera& camera) {
  return std::hypot(double(camera.width), double(camera.height));
}

/// Too little texture or overlap is a finding of its own and never one about poses.
void judge_texture(PoseCheck& check) {
  int64_t bare = 0, unknown = 0;
  for (const PoseResidual& camera : check.cameras) {
    bare += camera.features < kLeastFeatures;
    unknown += camera.residual < 0;
  }
  const auto all = int64_t(check.cameras.size());
  if (unknown == 0) return;
  const bool most = 2 * unknown > all;
  check.findings.push_back(
      {most ? Severity::kWarning : Severity::kInfo, "texture", "",
       fmt::format("{} of {} cameras have too few matches to check their poses ({} with fewer than "
                   "{} features)",
                   unknown, all, bare, kLeastFeatures),
       most ? "the images have little texture or overlap: coverage and a dense initial cloud "
              "decide here, not the poses"
            : ""});
}

/// Of a moving camera in a moving scene an image may disagree because of what moved: no verdict.
void judge_cameras(double image_diagonal, bool moving_camera, PoseCheck& check) {
  size_t named = 0;
  for (const PoseResidual& camera : check.cameras) {
    const bool outlier = camera.residual > std::max(3 * check.median, 1e-9);
    if (!outlier || camera.residual < kSuspicious * image_diagonal || ++named > kMostNamed)
      continue;
    const Severity severity = moving_camera                               ? Severity::kInfo
                              : camera.residual > kWrong * image_diagonal ? Severity::kError
                                                                          : Severity::kWarning;
    check.findings.push_back({severity, "poses", camera.camera,
                              fmt::format("poses disagree by {:.1f} px (median of all {:.2f})",
                                          camera.residual, check.median),
                              moving_camera
                                  ? "what moves between its timestep and the others' may explain it"
                                  : "estimate its pose again or leave it out with --cameras"});
  }
  if (check.median > kSuspicious * image_diagonal)
    check.findings.push_back(
        {Severity::kWarning, "poses", "",
         fmt::format("the cameras disagree by {:.1f} px in the median", check.median),
         "poses, lens distortion or clocks are off for all of them: estimate the poses again"});
}

}  // namespace

PoseCheck check_poses(const MatchedStations& matched) {
  const size_t count = matched.stations.size();
  std::vector<std::vector<double>> of_pairs(count);
  PoseCheck check;
  for (size_t s = 0; s < count; ++s)
    check.cameras.push_back({matched.stations[s].name, matched.features[s], 0, 0, -1});
  for (const StationPair& pair : matched.pairs) {
    std::vector<double> residuals;
    for (const FeatureMatch& match : pair.matches) residuals.push_back(match.residual);
    for (const int s : {pair.a, pair.b}) {
      check.cameras[size_t(s)].matches += int64_t(residuals.size());
      if (residuals.size() >= kLeastMatches) of_pairs[size_t(s)].push_back(median(residuals));
    }
  }
  std::vector<double> known;
  double largest = 0;
  for (size_t s = 0; s < count; ++s) {
    largest = std::max(largest, diagonal(matched.stations[s].camera));
    check.cameras[s].pairs = int(of_pairs[s].size());
    if (of_pairs[s].size() < 2) continue;  // of one pair nobody knows which camera it is
    check.cameras[s].residual = median(of_pairs[s]);
    known.push_back(check.cameras[s].residual);
  }
  std::stable_sort(
      check.cameras.begin(), check.cameras.end(),
      [](const PoseResidual& a, const PoseResidual& b) { return a.residual > b.residual; });
  judge_texture(check);
  if (known.empty()) return check;
  check.median = median(known);
  judge_cameras(largest, matched.moving_camera, check);
  check.findings.push_back({Severity::kInfo, "poses", check.cameras.front().camera,
                            fmt::format("largest residual {:.2f} px, median of all {:.2f}",
                                        check.cameras.front().residual, check.median),
                            ""});
  return check;
}

}  // namespace tessera
