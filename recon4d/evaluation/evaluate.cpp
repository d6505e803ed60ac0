// Renders a split group by group and scores the views of a group at once.
#include "recon4d/evaluation/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <future>
#include <set>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/evaluation/clock_fit.h"
#include "recon4d/evaluation/mean_scores.h"
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
                                 scene.path, name_of(split)));
  std::erase_if(indices, [&](int i) {
    const std::vector<uint8_t>& mask = scene.frames[size_t(i)].mask.data();
    return !mask.empty() && std::all_of(mask.begin(), mask.end(), [](uint8_t m) { return m == 0; });
  });
  if (indices.empty())
    throw InputError(fmt::format(
        "{}: the masks of split '{}' ignore every pixel (0: ignored); turn them with `tessera "
        "ingest --invert-masks`, or choose another split",
        scene.path, name_of(split)));
  return indices;
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

/// Score of one image against a frame, also given in 8 bits. The held-out flags are left false,
/// and what needs other pixels or views is left empty.
ViewScore score_view(const Frame& frame, const RenderedImage& image, const Image8& drawn,
                     const EvaluateOptions& options) {
  ViewScore score;
  score.name = frame.name;
  score.camera = frame.camera_name;
  score.time = frame.time;
  score.width = image.width;
  score.height = image.height;
  const Span<const uint8_t> mask = used_mask(frame);
  score.masked = !mask.empty();
  score.mse = mean_squared_error(drawn, frame.image, mask);
  score.psnr = psnr_of_mse(score.mse);
  score.psnr_float = psnr_float(image.planar(), frame.image, mask);
  if (options.structure == StructureDetail::kAll)
    static_cast<StructureScores&>(score) = structure_scores(drawn, frame.image, mask);
  else if (options.structure == StructureDetail::kSsim)
    score.reflect = ssim(drawn, frame.image, SsimPadding::kReflect, mask);
  if (options.lpips) score.lpips = options.lpips(only_used(drawn, frame), frame.image);
  return score;
}

/// Views that follow each other, rendered and then scored together.
struct ViewGroup {
  size_t begin = 0;  // place of the first among those that are scored
  std::vector<RenderedImage> images;
  std::vector<Image8> drawn;
  std::vector<ViewScore> scores;
  std::vector<ViewPixelSums> sums;
};

/// The views of a split, group after group: while one is scored on all threads, the next is drawn.
class SplitScorer {
 public:
  SplitScorer(Backend& backend, const GaussianModel& model, const Scene& scene, Split split,
              const EvaluateOptions& options)
      : scene_(scene),
        options_(options),
        indices_(scored_frames(scene, split)),
        training_(scene),
        group_size_(group_size()),
        held_out_(split == Split::kVal || split == Split::kTest),
        renderer_(backend, model),
        clocks_(options.fit_clocks ? fit_clocks(renderer_, scene, indices_)
                                   : std::map<std::string, double>()),
        moving_(backend, model, options),
        pixels_(scene, indices_, options) {
    check_background(model, scene);
    report_.split = split;
  }

  EvaluationReport report(const ScoredCallback& scored) {
    std::future<ViewGroup> before;
    for (size_t begin = 0; begin < indices_.size(); begin += group_size_) {
      ViewGroup group = drawn_group(begin);
      if (before.valid()) spare_ = taken(before.get(), scored);
      before = std::async(
          policy(), [this](ViewGroup drawn) { return look_at(std::move(drawn)); },
          std::move(group));
    }
    taken(before.get(), scored);
    pixels_.finish(report_);
    add_means(report_);
    report_.moving = moving_.score();
    report_.clock_fit = clocks_;
    return std::move(report_);
  }

 private:
  const Frame& frame(size_t i) const { return scene_.frames[size_t(indices_[i])]; }

  double clock_of(const Frame& frame) const {
    return clocks_.empty() ? 0 : clocks_.at(frame.camera_name);
  }

  /// As many views as threads score at once, of large images fewer: two groups are held, of 19
  /// bytes a pixel.
  size_t group_size() const {
    constexpr int64_t kMostViews = 16, kMostPixels = int64_t{1} << 25;
    int64_t largest = 1;
    for (const int i : indices_) {
      const Image8& image = scene_.frames[size_t(i)].image;
      largest = std::max(largest, int64_t(image.width) * image.height);
    }
    return size_t(std::max<int64_t>(
        options_.batch, std::min({int64_t(thread_count()), kMostViews, kMostPixels / largest})));
  }
  /// Work beside other work stays on its thread.
  static std::launch policy() {
    return SerialSection::is_here() ? std::launch::deferred : std::launch::async;
  }

  ViewGroup drawn_group(size_t begin) {
    ViewGroup group = std::move(spare_);
    group.begin = begin;
    const size_t last = std::min(begin + group_size_, indices_.size());
    group.images.resize(last - begin);
    for (size_t first = begin; first < last; first += size_t(options_.batch)) {
      std::vector<View> views;
      for (size_t i = first; i < std::min(first + size_t(options_.batch), last); ++i)
        views.push_back({frame(i).camera, frame(i).time + clock_of(frame(i))});
      moving_.add(views, scene_, indices_.data() + first);
      renderer_.render(views, {&group.images[first - begin], int64_t(views.size())});
    }
    return group;
  }

  ViewGroup look_at(ViewGroup group) const {
    const auto count = int64_t(group.images.size());
    group.drawn.resize(size_t(count));
    group.scores.resize(size_t(count));
    group.sums.resize(size_t(count));
    // a network scores one pair at a time
    parallel_for(count, options_.lpips ? count : 1, [&](int64_t first, int64_t last) {
      for (auto k = size_t(first); k < size_t(last); ++k) {
        const Frame& truth = frame(group.begin + k);
        const RenderedImage& image = group.images[k];
        group.drawn[k] = quantise(image.planar(), image.width, image.height);
        group.scores[k] = score_view(truth, image, group.drawn[k], options_);
        group.sums[k] = pixels_.look_at(truth, group.drawn[k], group.scores[k]);
      }
    });
    return group;
  }

  /// The group, whose memory the next one may use.
  ViewGroup taken(ViewGroup group, const ScoredCallback& scored) {
    for (size_t k = 0; k < group.images.size(); ++k) {
      const size_t i = group.begin + k;
      pixels_.add(frame(i), group.images[k], group.drawn[k], group.sums[k]);
      ViewScore score = group.scores[k];
      score.held_out_view = held_out_ && training_.has_timestep(frame(i).timestep);
      score.held_out_time = held_out_ && training_.has_camera(frame(i).camera_name);
      report_.views.push_back(score);
      if (scored)
        scored(frame(i), group.images[k], score, int64_t(i + 1), int64_t(indices_.size()));
    }
    return group;
  }

  const Scene& scene_;
  const EvaluateOptions& options_;
  const std::vector<int> indices_;
  const TrainingCoverage training_;
  const size_t group_size_;
  const bool held_out_;
  Renderer renderer_;
  const std::map<std::string, double> clocks_;
  MovingRegionMeter moving_;
  PixelScores pixels_;
  ViewGroup spare_;
  EvaluationReport report_;
};

}  // namespace

EvaluationReport evaluate(Backend& backend, const GaussianModel& model, const Scene& scene,
                          Split split, const EvaluateOptions& options,
                          const ScoredCallback& scored) {
  check(options.batch >= 1, "evaluate: a batch of at least one view");
  return SplitScorer(backend, model, scene, split, options).report(scored);
}

}  // namespace tessera
