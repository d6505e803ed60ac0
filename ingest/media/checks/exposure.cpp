// What: the fit of gains by iteratively reweighted least squares on a small dense system.
// Not: the matches (feature_matches.h).
#include "ingest/media/checks/exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr int64_t kLeastPairs = 20;  // below, a gain would be an accident
constexpr double kVisible = 0.05;    // of a gain: 6 levels at half white
constexpr int kIterations = 30;
constexpr double kMatchResidual = 6;  // pixels: matches that are farther off are not matches

struct LogRatio {
  int a, b;
  double value;
};

/// log gains of one channel with mean 0; the weak pull to 0 decides where nothing else does.
cv::Mat solve(const std::vector<LogRatio>& ratios, const std::vector<double>& weights,
              int cameras) {
  constexpr double kPull = 1e-6;
  cv::Mat normal = cv::Mat::eye(cameras, cameras, CV_64F) * kPull;
  cv::Mat right = cv::Mat::zeros(cameras, 1, CV_64F);
  for (size_t i = 0; i < ratios.size(); ++i) {
    const auto& [a, b, value] = ratios[i];
    const double w = weights[i];
    normal.at<double>(a, a) += w;
    normal.at<double>(b, b) += w;
    normal.at<double>(a, b) -= w;
    normal.at<double>(b, a) -= w;
    right.at<double>(a) += w * value;
    right.at<double>(b) -= w * value;
  }
  cv::Mat solution;
  cv::solve(normal, right, solution, cv::DECOMP_CHOLESKY);
  return solution;
}

std::vector<double> log_gains(const std::vector<LogRatio>& ratios, int cameras) {
  std::vector<double> weights(ratios.size(), 1.0);
  cv::Mat gains;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    gains = solve(ratios, weights, cameras);
    std::vector<double> residuals;
    for (const auto& [a, b, value] : ratios)
      residuals.push_back(std::abs(value - gains.at<double>(a) + gains.at<double>(b)));
    // 95 % efficient for a normal
    const double huber = std::max(1e-6, 1.345 * 1.4826 * median(residuals));
    for (size_t i = 0; i < weights.size(); ++i)
      weights[i] = residuals[i] <= huber ? 1 : huber / residuals[i];
  }
  return {gains.begin<double>(), gains.end<double>()};
}

}  // namespace

std::vector<CameraGain> fit_gains(const std::vector<std::string>& cameras,
                                  const std::vector<ColourPair>& pairs) {
  std::vector<CameraGain> gains;
  for (const std::string& camera : cameras) gains.push_back({camera, {1, 1, 1}, 0});
  std::vector<int64_t> used(cameras.size());
  for (const ColourPair& pair : pairs) {
    ++used[size_t(pair.a)];
    ++used[size_t(pair.b)];
  }
  for (size_t c = 0; c < cameras.size(); ++c) gains[c].pairs = used[c];
  for (size_t k = 0; k < 3; ++k) {
    std::vector<LogRatio> ratios;
    for (const ColourPair& pair : pairs)
      if (pair.colour_a[k] > 0 && pair.colour_b[k] > 0 && used[size_t(pair.a)] >= kLeastPairs &&
          used[size_t(pair.b)] >= kLeastPairs)
        ratios.push_back({pair.a, pair.b, std::log(pair.colour_a[k] / pair.colour_b[k])});
    if (ratios.empty()) continue;
    const std::vector<double> logs = log_gains(ratios, int(cameras.size()));
    double sum = 0, count = 0;
    for (size_t c = 0; c < cameras.size(); ++c)
      if (used[c] >= kLeastPairs) {
        sum += std::exp(logs[c]);
        ++count;
      }
    for (size_t c = 0; c < cameras.size(); ++c)
      if (used[c] >= kLeastPairs) gains[c].gain[k] = std::exp(logs[c]) * count / sum;
  }
  return gains;
}

std::vector<CameraGain> fit_exposure(const MatchedStations& matched) {
  std::vector<std::string> names;
  std::vector<int> place;  // [stations] among those that train, −1: held out
  for (const Station& station : matched.stations) {
    place.push_back(station.split == Split::kTrain ? int(names.size()) : -1);
    if (station.split == Split::kTrain) names.push_back(station.name);
  }
  std::vector<ColourPair> colours;
  for (const StationPair& pair : matched.pairs) {
    const int a = place[size_t(pair.a)], b = place[size_t(pair.b)];
    if (a < 0 || b < 0) continue;
    for (const FeatureMatch& match : pair.matches)
      if (match.residual < kMatchResidual)
        colours.push_back({a, b, colour_at(matched.images[size_t(pair.a)], match.ax, match.ay),
                           colour_at(matched.images[size_t(pair.b)], match.bx, match.by)});
  }
  return fit_gains(names, colours);
}

void apply_exposure(Image8& image, const std::array<double, 3>& gain) {
  const auto channels = size_t(image.channels);
  const double grey = (gain[0] + gain[1] + gain[2]) / 3;
  for (size_t p = 0; p < image.data.size(); p += channels)
    for (size_t k = 0; k < (channels == 1 ? 1 : 3); ++k) {
      const double value = image.data[p + k] / (channels == 1 ? grey : gain[k]);
      image.data[p + k] = uint8_t(std::clamp(std::lround(value), 0L, 255L));
    }
}

namespace {

/// Mean of the image by channel, 8-bit values.
std::array<double, 3> mean_colour(const Image8& image) {
  std::array<double, 3> sum{};
  for (size_t p = 0; p + 2 < image.data.size(); p += 3)
    for (size_t k = 0; k < 3; ++k) sum[k] += image.data[p + k];
  for (double& of_channel : sum)
    of_channel = std::max(1.0, of_channel * 3) / double(image.data.size());
  return sum;
}

/// Cameras without enough matches, by their whole images against the median of all: coarse, as what
/// they see differs, too.
void judge_whole_images(const MatchedStations& matched, ExposureCheck& check) {
  constexpr double kFar = 1.35;  // of a ratio: one stop of light, 2^(1/2.2) in display values
  std::vector<std::array<double, 3>> means;  // [gains]
  for (size_t s = 0; s < matched.stations.size(); ++s)
    if (matched.stations[s].split == Split::kTrain) means.push_back(mean_colour(matched.images[s]));
  std::array<double, 3> usual{};
  for (size_t k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const auto& mean : means) values.push_back(mean[k]);
    usual[k] = lower_median(std::move(values));
  }
  size_t named = 0;
  for (size_t c = 0; c < means.size(); ++c) {
    if (check.gains[c].pairs >= kLeastPairs) continue;
    std::array<double, 3> ratio{};
    double most = 1;
    for (size_t k = 0; k < 3; ++k) {
      ratio[k] = means[c][k] / usual[k];
      most = std::max({most, ratio[k], 1 / ratio[k]});
    }
    if (most < kFar || ++named > kMostNamed) continue;
    check.findings.push_back(
        {Severity::kWarning, "exposure", check.gains[c].camera,
         fmt::format("its images have {:.2f} {:.2f} {:.2f} (R G B) of the median camera's level, "
                     "and share too few features with others to tell exposure from content",
                     ratio[0], ratio[1], ratio[2]),
         "compare its images by eye; where the exposure differs, train with --exposure camera"});
  }
}

/// Gains of the cameras that have one, against the median by channel: one dark camera moves the
/// mean, by which all others would look bright.
void compare_with_median(std::vector<CameraGain>& gains) {
  for (size_t k = 0; k < 3; ++k) {
    std::vector<double> known;
    for (const CameraGain& camera : gains)
      if (camera.pairs >= kLeastPairs) known.push_back(camera.gain[k]);
    if (known.empty()) return;
    const double usual = median(std::move(known));
    for (CameraGain& camera : gains)
      if (camera.pairs >= kLeastPairs) camera.gain[k] /= usual;
  }
}

}  // namespace

ExposureCheck check_exposure(const MatchedStations& matched) {
  ExposureCheck check{fit_exposure(matched), {}};
  compare_with_median(check.gains);
  std::vector<std::pair<double, size_t>> worst;
  size_t known = 0;
  for (size_t c = 0; c < check.gains.size(); ++c) {
    double most = 0;
    for (const double gain : check.gains[c].gain) most = std::max(most, std::abs(gain - 1));
    worst.push_back({-most, c});
    known += check.gains[c].pairs >= kLeastPairs;
  }
  std::sort(worst.begin(), worst.end());
  for (size_t i = 0; i < std::min(kMostNamed, worst.size()); ++i) {
    const CameraGain& camera = check.gains[worst[i].second];
    if (-worst[i].first < kVisible || matched.moving_camera) break;
    check.findings.push_back({Severity::kWarning, "exposure", camera.camera,
                              fmt::format("records {:.3f} {:.3f} {:.3f} (R G B) of the median "
                                          "camera",
                                          camera.gain[0], camera.gain[1], camera.gain[2]),
                              "prepare with --exposure fit"});
  }
  if (known < check.gains.size() && !matched.moving_camera) judge_whole_images(matched, check);
  if (known < check.gains.size())
    check.findings.push_back({Severity::kInfo, "exposure", "",
                              fmt::format("{} of {} cameras share too few features to compare",
                                          check.gains.size() - known, check.gains.size()),
                              ""});
  else if (!worst.empty())
    check.findings.push_back(
        {Severity::kInfo, "exposure", check.gains[worst.front().second].camera,
         fmt::format("largest difference of a gain {:.1f} %", -100 * worst.front().first), ""});
  return check;
}

}  // namespace tessera
