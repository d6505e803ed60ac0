// Lists are joined, and means are taken again over all that is in them.
#include "tools/clip/joined_report.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "recon4d/evaluation/mean_scores.h"
#include "recon4d/evaluation/metrics.h"

namespace tessera {
namespace {

nlohmann::json or_null(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

/// Of PSNRs of equally many pixels, that of their mean squared error.
double psnr_over(const std::vector<TimestepScore>& timesteps) {
  double error = 0;
  for (const TimestepScore& score : timesteps)
    error += std::pow(10.0, -score.psnr / 10) / double(timesteps.size());
  return psnr_of_mse(error);
}

/// The mean of two values by the weights, over those that there are.
std::optional<double> mean_of(const std::optional<double>& a, double a_weight,
                              const std::optional<double>& b, double b_weight) {
  if (!a) return b;
  if (!b) return a;
  return (*a * a_weight + *b * b_weight) / (a_weight + b_weight);
}

}  // namespace

void JoinedReport::add(EvaluationReport part, double origin, double length) {
  const auto in_clip = [&](double& time) { time = origin + length * time; };
  if (++parts_ == 1) whole_ = part;
  all_.split = part.split;
  if (part.moving) {
    if (!all_.moving) all_.moving.emplace();
    all_.moving->weight += part.moving->weight;
    all_.moving->weight_inside += part.moving->weight_inside;
    all_.moving->moving_pixels += part.moving->moving_pixels;
    all_.moving->covered_pixels += part.moving->covered_pixels;
  }
  for (ViewScore& view : part.views) {
    in_clip(view.time);
    all_.views.push_back(std::move(view));
  }
  for (TimestepScore& score : part.timesteps) {
    in_clip(score.time);
    all_.timesteps.push_back(score);
  }
  for (ObjectScore& object : part.objects) {
    ObjectScore& known = objects_[object.name];
    known.name = object.name;
    for (TimestepScore& score : object.timesteps) {
      in_clip(score.time);
      known.timesteps.push_back(score);
    }
  }
  for (const FlickerScore& score : part.flicker) {
    const auto here = double(score.timesteps - 1);
    const auto [known, is_new] = flicker_.try_emplace(score.camera, Flicker{score, here});
    if (is_new) continue;
    FlickerScore& joined = known->second.score;
    const double before = known->second.pairs;
    known->second.pairs += here;
    const auto mean = [&](double a, double b) { return (a * before + b * here) / (before + here); };
    joined.change_error = mean(joined.change_error, score.change_error);
    joined.still_share = mean(joined.still_share, score.still_share);
    joined.still_deviation = mean_of(joined.still_deviation, before, score.still_deviation, here);
    joined.still_deviation_truth =
        mean_of(joined.still_deviation_truth, before, score.still_deviation_truth, here);
    joined.timesteps += score.timesteps;
  }
}

EvaluationReport JoinedReport::finish() {
  if (parts_ == 1) return std::move(whole_);
  for (auto& [name, object] : objects_) {
    object.psnr = psnr_over(object.timesteps);
    all_.objects.push_back(std::move(object));
  }
  for (const auto& [camera, flicker] : flicker_) all_.flicker.push_back(flicker.score);
  add_means(all_);
  return std::move(all_);
}

nlohmann::json to_json(const BorderScore& score) {
  return {{"inside", or_null(score.inside.all)},
          {"inside_moving", or_null(score.inside.moving)},
          {"border", or_null(score.border.all)},
          {"border_moving", or_null(score.border.moving)}};
}

}  // namespace tessera
