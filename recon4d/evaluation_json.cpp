// What: an EvaluationReport as the JSON object of `evaluate --json` and metrics.json.
// Not: any arithmetic.
#include <nlohmann/json.hpp>

#include "recon4d/evaluate.h"

namespace tessera {
namespace {

using nlohmann::json;

template <class T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}

void put_means(const MeanScore& mean, json& object) {
  object["psnr"] = or_null(mean.psnr);
  object["psnr_float"] = or_null(mean.psnr_float);
  object["psnr_of_mean_mse"] = or_null(mean.psnr_of_mean_mse);
  object["ssim"] = or_null(mean.ssim_reflect);
  object["ssim_zero"] = or_null(mean.ssim_zero);
  object["views"] = mean.views;
}

json view_json(const ViewScore& view) {
  return {{"name", view.name},
          {"camera", view.camera},
          {"time", view.time},
          {"width", view.width},
          {"height", view.height},
          {"psnr", view.psnr},
          {"psnr_float", view.psnr_float},
          {"ssim", or_null(view.ssim_reflect)},
          {"ssim_zero", or_null(view.ssim_zero)},
          {"held_out_view", view.held_out_view},
          {"held_out_time", view.held_out_time},
          {"masked", view.masked}};
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
  object["num_gaussians"] = model.count();
  object["num_static"] = model.static_set.count();
  object["num_dynamic"] = model.dynamic_set.count();
  object["bytes"] = or_null(report.bytes);
  object["split"] = split_name(report.split);
  object["background"] = model.background;
  object["width"] = shared_size(report.views, &ViewScore::width);
  object["height"] = shared_size(report.views, &ViewScore::height);
  put_means(report.held_out_views, object["held_out_views"]);
  put_means(report.held_out_times, object["held_out_times"]);
  object["per_view"] = json::array();
  for (const ViewScore& view : report.views) object["per_view"].push_back(view_json(view));
  return object;
}

}  // namespace tessera
