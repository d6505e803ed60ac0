// An EvaluationReport as the JSON object of `evaluate --json` and metrics.json.
#include <nlohmann/json.hpp>

#include "recon4d/evaluation/score_rows.h"

namespace tessera {
namespace {

using nlohmann::json;

template <class T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}

void put_scores(const OptionalScores& scores, json& object) {
  for (const ScoreRow& row : kScoreRows) object[row.name] = or_null(scores.*row.score);
  object["dssim"] = scores.reflect ? json((1 - *scores.reflect) / 2) : json(nullptr);
}

void put_means(const MeanScore& mean, json& object) {
  object["psnr"] = or_null(mean.psnr);
  object["psnr_float"] = or_null(mean.psnr_float);
  object["psnr_of_mean_mse"] = or_null(mean.psnr_of_mean_mse);
  put_scores(mean, object);
  object["dynamic_views"] = mean.dynamic_views;
  object["views"] = mean.views;
}

/// What the names of `put_means` mean: the same images score differently by definition.
json definitions() {
  json definitions = {
      {"psnr", "mean over views of 10 log10(1/MSE), 8-bit images, all channels"},
      {"psnr_float", "the same, rendered values clamped and not rounded"},
      {"psnr_of_mean_mse", "of the mean MSE over views"},
      {"dssim", "(1 - ssim) / 2, of ssim at range 1"},
      {"timesteps", "PSNR of the mean squared error over all views of a timestep"},
      {"dynamic_weight_inside",
       "of the blending weight of dynamic Gaussians over all pixels, the share in pixels where "
       "the mask says that something ever moves in that view (values from 128)"},
      {"moving_pixels_covered",
       "of the pixels that move at that timestep over half of them or more (values from 192), "
       "those where dynamic Gaussians have half of the light or more"},
      {"flicker",
       "change_error: mean |change of the render - change of the truth| between timesteps, in "
       "1/255; still_deviation: mean standard deviation over time of the render where that of the "
       "truth is below 2/255"}};
  for (const ScoreRow& row : kScoreRows) definitions[row.name] = row.definition;
  return definitions;
}

json flicker_json(const std::vector<FlickerScore>& cameras) {
  if (cameras.empty()) return nullptr;
  json object = {{"cameras", json::array()}};
  double change = 0, still = 0;
  size_t with_still = 0;
  for (const FlickerScore& score : cameras) {
    object["cameras"].push_back({{"camera", score.camera},
                                 {"moments", score.timesteps},
                                 {"change_error", score.change_error},
                                 {"still_share", score.still_share},
                                 {"still_deviation", or_null(score.still_deviation)},
                                 {"still_deviation_truth", or_null(score.still_deviation_truth)}});
    change += score.change_error;
    still += score.still_deviation.value_or(0);
    with_still += score.still_deviation.has_value();
  }
  object["change_error"] = change / double(cameras.size());
  object["still_deviation"] = with_still > 0 ? json(still / double(with_still)) : json(nullptr);
  return object;
}

json colour_fit_json(const std::vector<CameraColourFit>& cameras) {
  json object = json::object();
  for (const CameraColourFit& camera : cameras)
    object[camera.camera] = {{"gain", camera.fit.gain}, {"offset", camera.fit.offset}};
  return object;
}

json timestep_json(const TimestepScore& score) {
  return {{"time", score.time},
          {"frame_number", score.frame_number},
          {"views", score.views},
          {"psnr", score.psnr},
          {"psnr_dynamic", or_null(score.psnr_dynamic)}};
}

void put_timesteps(const std::vector<TimestepScore>& timesteps, json& object) {
  object["timesteps"] = json::array();
  for (const TimestepScore& score : timesteps) object["timesteps"].push_back(timestep_json(score));
  const std::optional<TimestepScore> worst = worst_timestep(timesteps);
  object["worst_timestep"] = worst ? timestep_json(*worst) : json(nullptr);
}

json object_json(const ObjectScore& object) {
  json timesteps = json::array();
  const auto without_regions = [](const TimestepScore& score) {
    json row = timestep_json(score);
    row.erase("psnr_dynamic");
    return row;
  };
  for (const TimestepScore& score : object.timesteps) timesteps.push_back(without_regions(score));
  return {{"name", object.name},
          {"psnr", object.psnr},
          {"worst", without_regions(*worst_timestep(object.timesteps))},
          {"timesteps", timesteps}};
}

json view_json(const ViewScore& view) {
  json object = {{"name", view.name},
                 {"camera", view.camera},
                 {"time", view.time},
                 {"width", view.width},
                 {"height", view.height},
                 {"psnr", view.psnr},
                 {"psnr_float", view.psnr_float},
                 {"held_out_view", view.held_out_view},
                 {"held_out_time", view.held_out_time},
                 {"masked", view.masked}};
  put_scores(view, object);
  return object;
}

/// The size all views share, or null.
json shared_size(const std::vector<ViewScore>& views, int ViewScore::*size) {
  if (views.empty()) return nullptr;
  for (const ViewScore& view : views)
    if (view.*size != views.front().*size) return nullptr;
  return views.front().*size;
}

}  // namespace

json to_json(const EvaluationReport& report, const GaussianModel& model) {
  json object;
  put_means(report.all, object);
  object["ssim_padding"] = "reflect";
  object["definitions"] = definitions();
  object["num_gaussians"] = model.count();
  object["num_static"] = model.static_set.count();
  object["num_dynamic"] = model.dynamic_set.count();
  object["bytes"] = or_null(report.bytes);
  object["split"] = name_of(report.split);
  object["background"] = model.background;
  object["width"] = shared_size(report.views, &ViewScore::width);
  object["height"] = shared_size(report.views, &ViewScore::height);
  put_means(report.held_out_views, object["held_out_views"]);
  put_means(report.held_out_times, object["held_out_times"]);
  put_means(report.novel_view, object["novel_view"]);
  put_means(report.novel_time, object["novel_time"]);
  put_means(report.novel_view_and_time, object["novel_view_and_time"]);
  put_means(report.withheld, object["withheld"]);
  object["colour_fit"] = colour_fit_json(report.colour_fit);
  object["clock_fit"] = nullptr;
  for (const auto& [camera, offset] : report.clock_fit)
    object["clock_fit"][camera] = offset * model.time_axis.duration;
  put_timesteps(report.timesteps, object);
  for (const ObjectScore& score : report.objects) object["objects"].push_back(object_json(score));
  object["flicker"] = flicker_json(report.flicker);
  if (report.moving) {
    object["dynamic_weight_inside"] = or_null(report.moving->dynamic_weight_inside());
    object["moving_pixels_covered"] = or_null(report.moving->moving_pixels_covered());
  }
  object["per_view"] = json::array();
  for (const ViewScore& view : report.views) object["per_view"].push_back(view_json(view));
  return object;
}

}  // namespace tessera
