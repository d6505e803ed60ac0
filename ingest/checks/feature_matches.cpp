// Matches cv::SIFT features by brute force with a ratio test, in parallel over pairs.
#include "ingest/checks/feature_matches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "ingest/checks/coverage.h"
#include "ingest/poses/epipolar.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr size_t kNeighbours = 5;
constexpr float kLoweRatio = 0.75f;  // of the best to the second best distance
constexpr double kGate = 30;         // pixels, and not below 3 % of the image's width

struct Features {
  std::vector<cv::KeyPoint> places;
  cv::Mat descriptors;
};

Features features_of(const Image8& image) {
  const cv::Mat colour(image.height, image.width, CV_8UC3, const_cast<uint8_t*>(image.data.data()));
  cv::Mat grey;
  cv::cvtColor(colour, grey, cv::COLOR_RGB2GRAY);
  Features features;
  cv::SIFT::create(kMostFeatures)
      ->detectAndCompute(grey, cv::noArray(), features.places, features.descriptors);
  return features;
}

/// For each row of `a` its match in `b` by the ratio test, −1 where there is none.
std::vector<int> best_of(const cv::Mat& a, const cv::Mat& b) {
  std::vector<int> best(size_t(a.rows), -1);
  std::vector<std::vector<cv::DMatch>> found;
  cv::BFMatcher(cv::NORM_L2).knnMatch(a, b, found, 2);
  for (const auto& two : found)
    if (two.size() == 2 && two[0].distance < kLoweRatio * two[1].distance)
      best[size_t(two[0].queryIdx)] = two[0].trainIdx;
  return best;
}

void match(const MatchedStations& matched, const std::vector<Features>& features,
           StationPair& pair) {
  const Features &a = features[size_t(pair.a)], &b = features[size_t(pair.b)];
  if (a.descriptors.rows < 2 || b.descriptors.rows < 2) return;
  const Camera& camera_a = matched.stations[size_t(pair.a)].camera;
  const Camera& camera_b = matched.stations[size_t(pair.b)].camera;
  const std::vector<int> forth = best_of(a.descriptors, b.descriptors);
  const std::vector<int> back = best_of(b.descriptors, a.descriptors);
  const glm::dmat3 f = fundamental(camera_a, camera_b);
  const double gate = std::max(kGate, 0.03 * camera_a.width);
  for (size_t i = 0; i < forth.size(); ++i) {
    if (forth[i] < 0 || back[size_t(forth[i])] != int(i)) continue;
    // OpenCV has pixel centres at whole numbers
    const cv::Point2f p = a.places[i].pt, q = b.places[size_t(forth[i])].pt;
    FeatureMatch found{p.x + 0.5, p.y + 0.5, q.x + 0.5, q.y + 0.5, 0};
    const glm::dvec3 in_a(found.ax, found.ay, 1), in_b(found.bx, found.by, 1);
    found.residual = std::abs(EpipolarMatch(in_b, f * in_a, glm::transpose(f) * in_b).distance());
    if (found.residual < gate) pair.matches.push_back(found);
  }
}

constexpr size_t kLeastMatches = 12;    // of a pair
constexpr int64_t kLeastFeatures = 60;  // of an image
constexpr double kSuspicious = 0.0015;  // of the diagonal: 0.9 pixels at 480 × 360
constexpr double kWrong = 0.0035;       // of the diagonal: 2.1 pixels at 480 × 360

double diagonal(const Camera& camera) {
  return std::hypot(double(camera.width), double(camera.height));
}

/// Too little texture or overlap is a separate finding and not one about poses.
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

MatchedStations match_stations(const Scene& scene) {
  MatchedStations matched;
  matched.stations = stations_of(scene);
  const size_t count = matched.stations.size();
  for (const Station& station : matched.stations)
    if (station.name != scene.frames[size_t(station.frames.front())].camera_name)
      matched.moving_camera = !scene.is_static;
  matched.images.resize(count);
  matched.features.resize(count);
  std::vector<Features> features(count);
  parallel_for(int64_t(count), 1, [&](int64_t begin, int64_t end) {
    for (auto s = size_t(begin); s < size_t(end); ++s) {
      matched.images[s] = median_image(scene, matched.stations[s]);
      features[s] = features_of(matched.images[s]);
      matched.features[s] = int64_t(features[s].places.size());
    }
  });
  constexpr size_t kSamples = 1500;
  const auto samples = view_samples(scene, matched.stations, kSamples);
  const auto neighbours = overlapping_stations(matched.stations, samples, kNeighbours);
  std::set<std::pair<int, int>> pairs;
  for (int a = 0; a < int(count); ++a)
    for (const int b : neighbours[size_t(a)]) pairs.insert({std::min(a, b), std::max(a, b)});
  for (const auto& [a, b] : pairs) matched.pairs.push_back({a, b, {}});
  parallel_for(int64_t(matched.pairs.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i) match(matched, features, matched.pairs[i]);
  });
  return matched;
}

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
    if (of_pairs[s].size() < 2) continue;  // one pair does not determine which camera is wrong
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
