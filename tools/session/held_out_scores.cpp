// What: evaluate over splits, joined into one object.
// Not: printing.
#include "tools/session/held_out_scores.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace tessera {

std::vector<Split> held_out_splits(const Scene& scene) {
  std::vector<Split> splits;
  for (Split split : {Split::kTest, Split::kVal})
    if (!scene.split_indices(split).empty()) splits.push_back(split);
  return splits;
}

nlohmann::json score_splits(Backend& backend, const GaussianModel& model, const Scene& scene,
                            const std::vector<Split>& splits, std::optional<int64_t> bytes,
                            const ScoredCallback& scored, const EvaluateOptions& options) {
  nlohmann::json result = nlohmann::json::object(), all = nlohmann::json::object();
  for (Split split : splits) {
    EvaluationReport report = evaluate(backend, model, scene, split, options, scored);
    report.bytes = bytes;
    const nlohmann::json scores = to_json(report, model);
    if (all.empty()) result = scores;
    all[split_name(split)] = scores;
  }
  if (!all.empty()) result["splits"] = all;
  return result;
}

namespace {

using nlohmann::json;

std::string number(const json& value, const char* format) {
  return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>())
                           : std::string("n/a");
}

/// What a split's scores have besides PSNR and SSIM, a line each.
std::string details_text(const json& score) {
  std::string text;
  const auto add = [&](const std::string& line) { text += "\n  " + line; };
  if (score["ms_ssim"].is_number() || score["lpips"].is_number())
    add(fmt::format("MS-SSIM {}, D-SSIM {}, LPIPS {}", number(score["ms_ssim"], "{:.4f}"),
                    number(score["dssim"], "{:.4f}"), number(score["lpips"], "{:.4f}")));
  for (const auto& [key, name] : {std::pair{"novel_view", "new views, known timesteps"},
                                  {"novel_time", "known views, new timesteps"},
                                  {"novel_view_and_time", "new views at new timesteps"},
                                  {"withheld", "known views at known timesteps"}}) {
    const json& group = score[key];
    // a split that is one group says so by its numbers above
    if (group["views"] > 0 && group["views"] < score["views"])
      add(fmt::format("{}: PSNR {} dB over {} views", name, number(group["psnr"], "{:.2f}"),
                      group["views"].get<int64_t>()));
  }
  if (score["psnr_dynamic"].is_number())
    add(fmt::format("pixels that move: PSNR {} dB, the others {} dB",
                    number(score["psnr_dynamic"], "{:.2f}"),
                    number(score["psnr_static"], "{:.2f}")));
  if (score.contains("dynamic_weight_inside"))
    add(
        fmt::format("moving region: {} of the dynamic weight lies in it, {} of its pixels are of "
                    "dynamic light",
                    number(score["dynamic_weight_inside"], "{:.3f}"),
                    number(score["moving_pixels_covered"], "{:.3f}")));
  if (score["flicker"].is_object())
    add(fmt::format("flicker: {}/255 beside the truth's change, {}/255 where the truth is still",
                    number(score["flicker"]["change_error"], "{:.2f}"),
                    number(score["flicker"]["still_deviation"], "{:.2f}")));
  return text;
}

}  // namespace

std::string scores_text(const json& scores) {
  std::string text;
  if (!scores.contains("splits")) return text;
  for (const auto& [split, score] : scores["splits"].items()) {
    text += fmt::format("{}{} PSNR {} dB, SSIM {} (reflect padding) over {} views",
                        text.empty() ? "" : "\n", split, number(score["psnr"], "{:.2f}"),
                        number(score["ssim"], "{:.4f}"), score["per_view"].size());
    text += details_text(score);
  }
  return text;
}

}  // namespace tessera
