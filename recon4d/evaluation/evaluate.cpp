// Renders a split in batches, scores each view, and computes the means of the scores, each over the
// views that have it.
#include "recon4d/evaluation/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/pixel_scores.h"

namespace tessera {
namespace {

/// What training saw: timesteps and cameras.
class TrainingCoverage {
 public:
  explicit TrainingCoverage(const Scene& scene) {
    for (const Frame& frame : scene.frames) {
      if (frame.split != Split::kTrain && frame.split != Split::kValidation) continue;
      timesteps_.insert(frame.timestep);
      cameras_.insert(frame.camera_name);
    }
  }
  bool has_timestep(int64_t timestep) const { return timesteps_.count(timestep) > 0; }
  bool has_camera(const std::string& camera) const { return cameras_.count(camera) > 0; }

 private:
  std::set<int64_t> timesteps_;
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

/// The frames of a split that have a pixel to be compared.
std::vector<int> scored_frames(const Scene& scene, Split split) {
  std::vector<int> indices = scene.split_indices(split);
  if (indices.empty())
    throw InputError(fmt::format("{}: no frame in split '{}'; choose another of train, val, test",
                                 scene.path, split_name(split)));
  std::erase_if(indices, [&](int i) {
    const std::vector<uint8_t>& mask = scene.frames[size_t(i)].mask.data();
    return !mask.empty() && std::all_of(mask.begin(), mask.end(), [](uint8_t m) { return m == 0; });
  });
  if (indices.empty())
    throw InputError(fmt::format(
        "{}: the masks of split '{}' ignore every pixel (0: ignored); turn them with `tessera "
        "ingest --invert-masks`, or choose another split",
        scene.path, split_name(split)));
  return indices;
}

MeanScore mean_of_those(const std::vector<ViewScore>& views,
                        const std::function<bool(const ViewScore&)>& belongs) {
  std::vector<ViewScore> chosen;
  std::copy_if(views.begin(), views.end(), std::back_inserter(chosen), belongs);
  return mean_score(chosen);
}

void add_means(EvaluationReport& report) {
  const std::vector<ViewScore>& views = report.views;
  report.all = mean_score(views);
  if (report.split == Split::kTrain || report.split == Split::kValidation) return;
  // a held-out view is one whose timestep was seen, a held-out time one whose camera was
  const auto group = [&](bool time_seen, bool camera_seen) {
    return mean_of_those(views, [=](const ViewScore& view) {
      return view.held_out_view == time_seen && view.held_out_time == camera_seen;
    });
  };
  report.held_out_views =
      mean_of_those(views, [](const ViewScore& view) { return view.held_out_view; });
  report.held_out_times =
      mean_of_those(views, [](const ViewScore& view) { return view.held_out_time; });
  report.novel_view = group(true, false);
  report.novel_time = group(false, true);
  report.novel_view_and_time = group(false, false);
  report.withheld = group(true, true);
}

/// `drawn` where the mask of the frame uses it, the truth elsewhere.
Image8 only_used(const Image8& drawn, const Frame& frame) {
  Image8 merged = drawn;
  for (size_t i = 0; i < merged.data.size() && !frame.mask.data().empty(); ++i)
    if (frame.mask.data()[i / 3] == 0) merged.data[i] = frame.image.data[i];
  return merged;
}

/// The share of the dynamic set against masks of what moves, where the options have such masks.
class MovingRegionMeter {
 public:
  MovingRegionMeter(Backend& backend, const GaussianModel& model, const EvaluateOptions& options)
      : mask_(options.moving_mask) {
    if (!mask_) return;
    white_.emplace(dynamic_set_white(model));
    renderer_.emplace(backend, *white_);
    score_.emplace();
  }
  void add(const std::vector<View>& views, const Scene& scene, const int* indices) {
    if (!mask_) return;
    for (RenderedImage& image : renderer_->render(views)) {
      const Frame& frame = scene.frames[size_t(*indices++)];
      image.rgb.resize(image.alpha.size());  // all channels are equal
      score_->add(image.rgb, mask_(frame).data, frame.mask.data());
    }
  }
  const std::optional<MovingRegionScore>& score() const { return score_; }

 private:
  const std::function<Image8(const Frame&)>& mask_;
  std::optional<GaussianModel> white_;
  std::optional<Renderer> renderer_;
  std::optional<MovingRegionScore> score_;
};

/// Mean of a member over the views that have it.
std::optional<double> mean_of(const std::vector<ViewScore>& views,
                              const std::function<std::optional<double>(const ViewScore&)>& value) {
  double sum = 0;
  int64_t count = 0;
  for (const ViewScore& view : views)
    if (const std::optional<double> v = value(view)) {
      sum += *v;
      ++count;
    }
  return count > 0 ? std::optional<double>(sum / double(count)) : std::nullopt;
}

}  // namespace

ViewScore score_view(const Frame& frame, const RenderedImage& image,
                     const EvaluateOptions& options) {
  ViewScore score;
  score.name = frame.name;
  score.camera = frame.camera_name;
  score.time = frame.time;
  score.width = image.width;
  score.height = image.height;
  const Image8 drawn = quantise(image.planar(), image.width, image.height);
  const Span<const uint8_t> mask = used_mask(frame);
  score.masked = !mask.empty();
  score.mse = mean_squared_error(drawn, frame.image, mask);
  score.psnr = psnr_of_mse(score.mse);
  score.psnr_float = psnr_float(image.planar(), frame.image, mask);
  if (options.structure == StructureDetail::kAll)
    score.structure = structure_scores(drawn, frame.image, mask);
  else if (options.structure == StructureDetail::kSsim)
    score.structure.reflect = ssim(drawn, frame.image, SsimPadding::kReflect, mask);
  if (options.lpips) score.lpips = options.lpips(only_used(drawn, frame), frame.image);
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
  MovingRegionMeter moving(backend, model, options);
  PixelScores pixels(scene, indices, options);
  for (size_t begin = 0; begin < indices.size(); begin += size_t(options.batch)) {
    const size_t end = std::min(begin + size_t(options.batch), indices.size());
    std::vector<View> views;
    for (size_t i = begin; i < end; ++i) {
      const Frame& frame = scene.frames[size_t(indices[i])];
      views.push_back({frame.camera, frame.time});
    }
    moving.add(views, scene, indices.data() + begin);
    const std::vector<RenderedImage> images = renderer.render(views);
    std::vector<ViewScore> scores(images.size());
    // a network scores one pair at a time
    parallel_for(int64_t(scores.size()), options.lpips ? int64_t(scores.size()) : 1,
                 [&](int64_t first, int64_t last) {
                   for (int64_t k = first; k < last; ++k)
                     scores[size_t(k)] =
                         score_view(scene.frames[size_t(indices[begin + size_t(k)])],
                                    images[size_t(k)], options);
                 });
    for (size_t i = begin; i < end; ++i) {
      const Frame& frame = scene.frames[size_t(indices[i])];
      ViewScore& score = scores[i - begin];
      const RenderedImage& image = images[i - begin];
      pixels.add(frame, image, score);
      const bool held_out = split == Split::kVal || split == Split::kTest;
      score.held_out_view = held_out && training.has_timestep(frame.timestep);
      score.held_out_time = held_out && training.has_camera(frame.camera_name);
      report.views.push_back(score);
      if (scored) scored(frame, image, score, int64_t(i + 1), int64_t(indices.size()));
    }
  }
  pixels.finish(report);
  add_means(report);
  report.moving = moving.score();
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
    case Split::kValidation:
      return "aside";
  }
  return "";
}

MeanScore mean_score(const std::vector<ViewScore>& views) {
  MeanScore mean;
  mean.views = int64_t(views.size());
  mean.psnr = mean_of(views, [](const ViewScore& v) { return v.psnr; });
  mean.psnr_float = mean_of(views, [](const ViewScore& v) { return v.psnr_float; });
  for (auto member : {&StructureScores::reflect, &StructureScores::zero, &StructureScores::inside,
                      &StructureScores::inside_range2, &StructureScores::multi_scale})
    mean.structure.*member =
        mean_of(views, [member](const ViewScore& v) { return v.structure.*member; });
  mean.lpips = mean_of(views, [](const ViewScore& v) { return v.lpips; });
  mean.psnr_dynamic = mean_of(views, [](const ViewScore& v) { return v.psnr_dynamic; });
  mean.psnr_static = mean_of(views, [](const ViewScore& v) { return v.psnr_static; });
  mean.psnr_fit = mean_of(views, [](const ViewScore& v) { return v.psnr_fit; });
  mean.psnr_fit_dynamic = mean_of(views, [](const ViewScore& v) { return v.psnr_fit_dynamic; });
  mean.psnr_fit_static = mean_of(views, [](const ViewScore& v) { return v.psnr_fit_static; });
  mean.dynamic_views = std::count_if(views.begin(), views.end(),
                                     [](const ViewScore& v) { return v.psnr_dynamic.has_value(); });
  if (const auto mse = mean_of(views, [](const ViewScore& v) { return v.mse; }))
    mean.psnr_of_mean_mse = psnr_of_mse(*mse);
  return mean;
}

}  // namespace tessera
