// What: batches of a split through the renderer, one score a view.
// Not: the metrics (metrics.h) or the JSON of a report (evaluation_json.cpp).
#include "recon4d/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "kernels/base/errors.h"
#include "recon4d/metrics.h"

namespace tessera {
namespace {

/// What training saw: moments and cameras.
class TrainingCoverage {
 public:
  explicit TrainingCoverage(const Scene& scene) {
    for (const Frame& frame : scene.frames) {
      if (frame.split != Split::kTrain) continue;
      times_.insert(frame.time);
      cameras_.insert(frame.camera_name);
    }
  }
  bool has_time(double time) const {
    constexpr double kSameMoment = 1e-9;  // of the normalised range
    const auto next = times_.lower_bound(time - kSameMoment);
    return next != times_.end() && *next <= time + kSameMoment;
  }
  bool has_camera(const std::string& camera) const { return cameras_.count(camera) > 0; }

 private:
  std::set<double> times_;
  std::set<std::string> cameras_;
};

void check_background(const GaussianModel& model, const Scene& scene) {
  const auto &m = model.background, &s = scene.background;
  if (scene.had_alpha && m != s)
    throw InputError(fmt::format(
        "{}: frames were composited on {},{},{}, the model was trained on {},{},{}; load the scene "
        "on the model's background",
        scene.path, s[0], s[1], s[2], m[0], m[1], m[2]));
}

/// Mean of a member over the views that have it.
std::optional<double> mean_of(const std::vector<ViewScore>& views,
                              const std::function<std::optional<double>(const ViewScore&)>& value) {
  double sum = 0;
  int64_t count = 0;
  for (const ViewScore& view : views)
    if (const std::optional<double> v = value(view)) sum += *v, ++count;
  return count > 0 ? std::optional<double>(sum / double(count)) : std::nullopt;
}

/// The frames of a split that have a pixel to be compared.
std::vector<int> scored_frames(const Scene& scene, Split split) {
  std::vector<int> indices = scene.split_indices(split);
  if (indices.empty())
    throw InputError(fmt::format("{}: no frame in split '{}'; choose another of train, val, test",
                                 scene.path, split_name(split)));
  std::erase_if(indices, [&](int i) {
    const std::vector<uint8_t>& mask = scene.frames[size_t(i)].mask.data;
    return !mask.empty() && std::all_of(mask.begin(), mask.end(), [](uint8_t m) { return m == 0; });
  });
  if (indices.empty())
    throw InputError(fmt::format(
        "{}: the masks of split '{}' ignore every pixel (0: ignored); turn them with `tessera "
        "ingest --invert-masks`, or choose another split",
        scene.path, split_name(split)));
  return indices;
}

MeanScore mean_of_those(const std::vector<ViewScore>& views, bool ViewScore::*flag) {
  std::vector<ViewScore> chosen;
  std::copy_if(views.begin(), views.end(), std::back_inserter(chosen),
               [flag](const ViewScore& view) { return view.*flag; });
  return mean_score(chosen);
}

}  // namespace

MeanScore mean_score(const std::vector<ViewScore>& views) {
  MeanScore mean;
  mean.views = int64_t(views.size());
  mean.psnr = mean_of(views, [](const ViewScore& v) { return v.psnr; });
  mean.psnr_float = mean_of(views, [](const ViewScore& v) { return v.psnr_float; });
  mean.ssim_reflect = mean_of(views, [](const ViewScore& v) { return v.ssim_reflect; });
  mean.ssim_zero = mean_of(views, [](const ViewScore& v) { return v.ssim_zero; });
  if (const auto mse = mean_of(views, [](const ViewScore& v) { return v.mse; }))
    mean.psnr_of_mean_mse = psnr_of_mse(*mse);
  return mean;
}

ViewScore score_view(const Frame& frame, const Picture& picture, const EvaluateOptions& options) {
  ViewScore score;
  score.name = frame.name, score.camera = frame.camera_name, score.time = frame.time;
  score.width = picture.width, score.height = picture.height;
  const Image8 drawn = quantise(picture.planar(), picture.width, picture.height);
  const Span<const uint8_t> mask{frame.mask.data.data(), int64_t(frame.mask.data.size())};
  score.masked = !mask.empty();
  score.mse = mean_squared_error(drawn, frame.image, mask);
  score.psnr = psnr_of_mse(score.mse);
  score.psnr_float = psnr_float(picture.planar(), frame.image, mask);
  score.ssim_reflect = ssim(drawn, frame.image, SsimPadding::kReflect, mask);
  if (options.ssim_zero) score.ssim_zero = ssim(drawn, frame.image, SsimPadding::kZero, mask);
  return score;
}

EvaluationReport evaluate(Backend& backend, const GaussianModel& model, const Scene& scene,
                          Split split, const EvaluateOptions& options,
                          const ScoredCallback& scored) {
  check(options.batch >= 1, "evaluate: a batch of at least one view");
  const std::vector<int> indices = scored_frames(scene, split);
  check_background(model, scene);
  const TrainingCoverage training(scene);
  EvaluationReport report;
  report.split = split;
  Renderer renderer(backend, model);
  for (size_t begin = 0; begin < indices.size(); begin += size_t(options.batch)) {
    const size_t end = std::min(begin + size_t(options.batch), indices.size());
    std::vector<View> views;
    for (size_t i = begin; i < end; ++i) {
      const Frame& frame = scene.frames[size_t(indices[i])];
      views.push_back({frame.camera, frame.time});
    }
    const std::vector<Picture> pictures = renderer.render(views);
    for (size_t i = begin; i < end; ++i) {
      const Frame& frame = scene.frames[size_t(indices[i])];
      ViewScore score = score_view(frame, pictures[i - begin], options);
      score.held_out_view = split != Split::kTrain && training.has_time(frame.time);
      score.held_out_time = split != Split::kTrain && training.has_camera(frame.camera_name);
      report.views.push_back(score);
      if (scored)
        scored(frame, pictures[i - begin], score, int64_t(i + 1), int64_t(indices.size()));
    }
  }
  report.all = mean_score(report.views);
  report.held_out_views = mean_of_those(report.views, &ViewScore::held_out_view);
  report.held_out_times = mean_of_those(report.views, &ViewScore::held_out_time);
  return report;
}

const char* split_name(Split split) {
  switch (split) {
    case Split::kTrain:
      return "train";
    case Split::kVal:
      return "val";
    case Split::kTest:
      return "test";
  }
  return "";
}

}  // namespace tessera
