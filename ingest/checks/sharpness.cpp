// Compares the Laplacian of an image at full and at half size, with medians over frames and
// cameras. A background out of focus lowers the value as motion blur does.
#include "ingest/checks/sharpness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "ingest/checks/stations.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr double kBlurred = 0.4;  // of the median
constexpr double kSmooth = 0.25;  // quotient of a smooth image: half size is 4 times as curved

double laplacian_deviation(const cv::Mat& grey) {
  cv::Mat laplacian;
  cv::Laplacian(grey, laplacian, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0];
}

std::map<std::string, std::vector<size_t>> frames_by_camera(const Scene& scene) {
  std::map<std::string, std::vector<size_t>> places;
  for (size_t i = 0; i < scene.frames.size(); ++i) places[scene.frames[i].camera_name].push_back(i);
  return places;
}

void judge(SharpnessCheck& check) {
  size_t named = 0;
  for (const CameraSharpness& camera : check.cameras) {
    if (camera.sharpness < 0) continue;
    const double relative = camera.sharpness / check.median;
    if (relative < kBlurred && ++named <= kMostNamed)
      check.findings.push_back(
          {Severity::kWarning, "blur", camera.camera,
           fmt::format("sharpness {:.2f} of the median camera", relative),
           "out of focus or moved: focus again, or leave it out with --cameras"});
    if (camera.softest_relative < kBlurred && ++named <= kMostNamed)
      check.findings.push_back({Severity::kWarning, "blur", camera.camera,
                                fmt::format("{} has sharpness {:.2f} of its camera's median",
                                            camera.softest, camera.softest_relative),
                                "motion blur or a bad frame: leave it out"});
  }
  if (named > kMostNamed)
    check.findings.push_back({Severity::kWarning, "blur", "",
                              fmt::format("{} more blurred cameras or frames", named - kMostNamed),
                              "see the table of --json"});
}

}  // namespace

double sharpness(const Image8& image) {
  const cv::Mat colour(image.height, image.width, CV_8UC3, const_cast<uint8_t*>(image.data.data()));
  cv::Mat grey, half;
  cv::cvtColor(colour, grey, cv::COLOR_RGB2GRAY);
  cv::resize(grey, half, {}, 0.5, 0.5, cv::INTER_AREA);
  const double coarse = laplacian_deviation(half);
  return coarse < 1 ? -1 : std::max(0.0, laplacian_deviation(grey) / coarse - kSmooth);
}

SharpnessCheck check_sharpness(const Scene& scene) {
  std::vector<double> of_frame(scene.frames.size());
  parallel_for(int64_t(of_frame.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i)
      of_frame[i] = sharpness(scene.frames[i].image);
  });
  SharpnessCheck check;
  std::vector<double> medians;
  for (const auto& [camera, frames] : frames_by_camera(scene)) {
    std::vector<double> values;
    size_t softest = frames.front();
    for (const size_t i : frames) {
      if (of_frame[i] < 0) continue;
      values.push_back(of_frame[i]);
      if (of_frame[softest] < 0 || of_frame[i] < of_frame[softest]) softest = i;
    }
    check.cameras.push_back({camera, -1, scene.frames[softest].name, 1});
    if (values.empty()) continue;
    check.cameras.back().sharpness = median(values);
    check.cameras.back().softest_relative = of_frame[softest] / check.cameras.back().sharpness;
    medians.push_back(check.cameras.back().sharpness);
  }
  if (!medians.empty()) check.median = median(medians);
  judge(check);
  return check;
}

}  // namespace tessera
