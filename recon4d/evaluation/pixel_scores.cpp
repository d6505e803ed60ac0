// Passes the pixel sums of each view to the meters, and fits the colours of cameras at the end.
#include "recon4d/evaluation/pixel_scores.h"

#include <map>
#include <string>

#include "recon4d/evaluation/metrics.h"

namespace tessera {
namespace {

std::optional<double> psnr_of(const PixelSums& sums) {
  if (sums.pixels == 0) return std::nullopt;
  return psnr_of_mse(sums.mean_squared_error());
}

std::optional<double> psnr_after(const ColourFit& fit, const PixelSums& sums) {
  if (sums.pixels == 0) return std::nullopt;
  return psnr_of_mse(fit.mean_squared_error(sums));
}

/// The fit of each camera over its views, and what its views score after it. `sums`: of each view.
void add_colour_fit(const std::vector<ViewPixelSums>& sums, EvaluationReport& report) {
  std::map<std::string, PixelSums> cameras;
  for (size_t i = 0; i < sums.size(); ++i) cameras[report.views[i].camera] += sums[i].all();
  std::map<std::string, ColourFit> fits;
  for (const auto& [camera, pixels] : cameras) {
    fits[camera] = fit_colour(pixels);
    report.colour_fit.push_back({camera, fits[camera]});
  }
  for (size_t i = 0; i < sums.size(); ++i) {
    ViewScore& view = report.views[i];
    const ColourFit& fit = fits[view.camera];
    view.psnr_fit = psnr_after(fit, sums[i].all());
    if (!sums[i].has_motion) continue;
    view.psnr_fit_dynamic = psnr_after(fit, sums[i].moving);
    view.psnr_fit_static = psnr_after(fit, sums[i].still);
  }
}

std::map<std::string, int64_t> frames_of_cameras(const Scene& scene,
                                                 const std::vector<int>& frames) {
  std::map<std::string, int64_t> cameras;
  for (const int i : frames) ++cameras[scene.frames[size_t(i)].camera_name];
  return cameras;
}

}  // namespace

PixelScores::PixelScores(const Scene& scene, const std::vector<int>& scored,
                         const EvaluateOptions& options)
    : options_(options), flicker_(frames_of_cameras(scene, scored)) {
  if (options.pixel_sums && options.temporal)
    regions_.emplace(scene, DynamicRegions::Of::kAllFrames, scored);
}

ViewPixelSums PixelScores::look_at(const Frame& frame, const Image8& drawn,
                                   ViewScore& score) const {
  if (!options_.pixel_sums) return {};
  const ViewPixelSums sums =
      view_sums(drawn, frame, regions_ ? regions_->mask_of(frame) : std::vector<uint8_t>());
  if (sums.has_motion) {
    score.psnr_dynamic = psnr_of(sums.moving);
    score.psnr_static = psnr_of(sums.still);
  }
  return sums;
}

void PixelScores::add(const Frame& frame, const RenderedImage& image, const Image8& drawn,
                      const ViewPixelSums& sums) {
  if (!options_.pixel_sums) return;
  sums_.push_back(sums);
  timesteps_.add(frame, sums);
  if (options_.object_boxes) objects_.add(frame, drawn, options_.object_boxes(frame));
  if (options_.temporal) flicker_.add(frame, image);
}

void PixelScores::finish(EvaluationReport& report) const {
  add_colour_fit(sums_, report);
  report.timesteps = timesteps_.scores();
  report.objects = objects_.scores();
  report.flicker = flicker_.scores();
}

}  // namespace tessera
