// What: numbers at equal places of several JSON objects.
// Not: files.
#include "tools/session/run_statistics.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/session/held_out_scores.h"

namespace tessera {
namespace {

using nlohmann::json;

json mean_and_sigma(const std::vector<double>& values) {
  const auto n = double(values.size());
  double mean = 0, square = 0;
  for (double value : values) mean += value / n;
  for (double value : values) square += (value - mean) * (value - mean);
  return {{"mean", mean},
          {"sigma", values.size() > 1 ? json(std::sqrt(square / (n - 1))) : json(nullptr)}};
}

/// Objects at the same place of every run; lists, texts and what only some have are left out.
json merged(const std::vector<const json*>& runs) {
  json result = json::object();
  for (const auto& [key, first] : runs.front()->items()) {
    std::vector<double> values;
    std::vector<const json*> children;
    for (const json* run : runs) {
      const auto found = run->find(key);
      if (found == run->end()) continue;
      if (found->is_number()) values.push_back(found->get<double>());
      if (found->is_object()) children.push_back(&*found);
    }
    if (values.size() == runs.size()) result[key] = mean_and_sigma(values);
    if (children.size() != runs.size()) continue;
    json child = merged(children);
    if (!child.empty()) result[key] = std::move(child);
  }
  return result;
}

}  // namespace

json over_runs(const std::vector<json>& scores) {
  std::vector<const json*> splits;
  for (const json& run : scores) splits.push_back(&run.at("splits"));
  return {{"count", scores.size()}, {"splits", merged(splits)}};
}

std::string over_runs_text(const json& statistics) {
  std::string text;
  const auto number = [](const json& score, int digits) {
    if (!score.is_object()) return std::string("n/a");
    return score["sigma"].is_null() ? fmt::format("{:.{}f}", score["mean"].get<double>(), digits)
                                    : fmt::format("{:.{}f} ± {:.{}f}", score["mean"].get<double>(),
                                                  digits, score["sigma"].get<double>(), digits);
  };
  for (const auto& [split, score] : statistics["splits"].items())
    text += fmt::format("{}{}: PSNR {} dB, SSIM {} ({} runs)", text.empty() ? "" : "\n",
                        views_text(split), number(score.value("psnr", json()), 2),
                        number(score.value("ssim", json()), 4), statistics["count"].get<int64_t>());
  return text;
}

}  // namespace tessera
