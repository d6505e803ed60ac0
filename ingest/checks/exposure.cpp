// Computes the gains of the stations from matched features, and the findings about them.
#include "ingest/checks/exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr double kVisible = 0.05;     // of a gain: 6 levels at half white
constexpr double kMatchResidual = 6;  // pixels: matches that are farther off are not matches

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
    if (check.gains[c].pairs >= kLeastColourPairs) continue;
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
/// mean, relative to which all others would be bright.
void compare_with_median(std::vector<CameraGain>& gains) {
  for (size_t k = 0; k < 3; ++k) {
    std::vector<double> known;
    for (const CameraGain& camera : gains)
      if (camera.pairs >= kLeastColourPairs) known.push_back(camera.gain[k]);
    if (known.empty()) return;
    const double usual = median(std::move(known));
    for (CameraGain& camera : gains)
      if (camera.pairs >= kLeastColourPairs) camera.gain[k] /= usual;
  }
}

}  // namespace

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

ExposureCheck check_exposure(const MatchedStations& matched) {
  ExposureCheck check{fit_exposure(matched), {}};
  compare_with_median(check.gains);
  std::vector<std::pair<double, size_t>> worst;
  size_t known = 0;
  for (size_t c = 0; c < check.gains.size(); ++c) {
    double most = 0;
    for (const double gain : check.gains[c].gain) most = std::max(most, std::abs(gain - 1));
    worst.push_back({-most, c});
    known += check.gains[c].pairs >= kLeastColourPairs;
  }
  std::sort(worst.begin(), worst.end());
  for (size_t i = 0; i < std::min(kMostNamed, worst.size()); ++i) {
    const CameraGain& camera = check.gains[worst[i].second];
    if (-worst[i].first < kVisible || matched.moving_camera) break;
    check.findings.push_back({Severity::kWarning, "exposure", camera.camera,
                              fmt::format("records {:.3f} {:.3f} {:.3f} (R G B) of the median "
                                          "camera",
                                          camera.gain[0], camera.gain[1], camera.gain[2]),
                              "the presets of rigs learn this (--exposure auto); for other "
                              "trainings prepare with --fit-exposure"});
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
