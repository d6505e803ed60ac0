// What: evaluate over splits, joined into one object.
// Not: printing.
#include "tools/held_out_scores.h"

#include <fmt/format.h>

namespace tessera {

std::vector<Split> held_out_splits(const Scene& scene) {
  std::vector<Split> splits;
  for (Split split : {Split::kTest, Split::kVal})
    if (!scene.split_indices(split).empty()) splits.push_back(split);
  return splits;
}

nlohmann::json score_splits(Backend& backend, const GaussianModel& model, const Scene& scene,
                            const std::vector<Split>& splits, std::optional<int64_t> bytes,
                            const ScoredCallback& scored) {
  nlohmann::json result = nlohmann::json::object(), all = nlohmann::json::object();
  for (Split split : splits) {
    EvaluationReport report = evaluate(backend, model, scene, split, {}, scored);
    report.bytes = bytes;
    const nlohmann::json scores = to_json(report, model);
    if (all.empty()) result = scores;
    all[split_name(split)] = scores;
  }
  if (!all.empty()) result["splits"] = all;
  return result;
}

std::string scores_text(const nlohmann::json& scores) {
  std::string text;
  const auto number = [](const nlohmann::json& value, const char* format) {
    return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>())
                             : std::string("n/a");
  };
  if (!scores.contains("splits")) return text;
  for (const auto& [split, score] : scores["splits"].items())
    text += fmt::format("{}{} PSNR {} dB, SSIM {} (reflect padding) over {} views",
                        text.empty() ? "" : "\n", split, number(score["psnr"], "{:.2f}"),
                        number(score["ssim"], "{:.4f}"), score["per_view"].size());
  return text;
}

}  // namespace tessera
