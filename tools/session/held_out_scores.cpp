// Evaluates split by split, joins the scores in one object and formats them in a few lines.
#include "tools/session/held_out_scores.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

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

std::vector<Split> held_out_splits(const Scene& scene) {
  std::vector<Split> splits;
  for (const Split split : kHeldOutSplits)
    if (!scene.split_indices(split).empty()) splits.push_back(split);
  return splits;
}

json by_split(const std::vector<Split>& splits, const std::function<json(Split)>& scores_of) {
  json result = json::object(), all = json::object();
  for (const Split split : splits) {
    json scores = scores_of(split);
    if (scores.is_null()) continue;
    if (all.empty()) result = scores;
    all[name_of(split)] = std::move(scores);
  }
  if (!all.empty()) result["splits"] = std::move(all);
  return result;
}

json score_splits(Backend& backend, const GaussianModel& model, const Scene& scene,
                  const std::vector<Split>& splits, const ScoredCallback& scored,
                  const EvaluateOptions& options) {
  return by_split(splits, [&](Split split) {
    return to_json(evaluate(backend, model, scene, split, options, scored), model);
  });
}

std::string number_text(const json& value, int digits) {
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : "n/a";
}

std::string views_text(const std::string& split) {
  if (split == "val") return "validation views";
  return split == "train" ? "training views" : split + " views";
}

namespace {

std::string in_a_word(double psnr) {
  if (psnr < 20) return "recognisable at best";
  if (psnr < 25) return "soft";
  if (psnr < 30) return "good";
  return psnr < 35 ? "sharp" : "hard to tell from what was recorded";
}

}  // namespace

std::string verdict(const json& score) {
  const auto word = [&](const char* name) {
    const json psnr = score.value(name, json());
    return psnr.is_number() ? in_a_word(psnr) : "";
  };
  const std::string still = word("psnr_static"), moving = word("psnr_dynamic");
  return still.empty() || moving.empty() || still == moving
             ? word("psnr")
             : fmt::format("{} where it stands still, {} where it moves", still, moving);
}

namespace {

using Lines = std::vector<std::string>;

void add_structure(const json& score, ScoreDetail detail, Lines& lines) {
  if (detail == ScoreDetail::kAll) {
    lines.push_back(
        fmt::format("SSIM {} with reflect padding, {} with zero padding, {} without padding",
                    number_text(score["ssim"], 4), number_text(score["ssim_zero"], 4),
                    number_text(score["ssim_inside"], 4)));
    lines.push_back(fmt::format("MS-SSIM {}, D-SSIM {}, LPIPS {}", number_text(score["ms_ssim"], 4),
                                number_text(score["dssim"], 4), number_text(score["lpips"], 4)));
  } else if (score["lpips"].is_number()) {
    lines.push_back(fmt::format("LPIPS {}", number_text(score["lpips"], 4)));
  }
}

void add_novelty(const json& score, Lines& lines) {
  for (const auto& [key, name] : {std::pair{"novel_view", "novel views at known timesteps"},
                                  {"novel_time", "known views at novel timesteps"},
                                  {"novel_view_and_time", "novel views at novel timesteps"},
                                  {"withheld", "known views at known timesteps"}}) {
    const json& group = score[key];
    // the line above has the scores of a split that is one group
    if (group["views"] > 0 && group["views"] < score["views"])
      lines.push_back(fmt::format("{} ({}): PSNR {} dB", name, group["views"].get<int64_t>(),
                                  number_text(group["psnr"], 2)));
  }
}

/// What each camera's best gain and offset make of the scores.
void add_colour_fit(const json& score, Lines& lines) {
  if (!score.contains("psnr_fit") || !score["psnr_fit"].is_number()) return;
  std::string line = fmt::format("PSNR {} dB after the best gain and offset of each camera",
                                 number_text(score["psnr_fit"], 2));
  if (score["psnr_fit_dynamic"].is_number())
    line += fmt::format(", moving pixels {} dB, static pixels {} dB",
                        number_text(score["psnr_fit_dynamic"], 1),
                        number_text(score["psnr_fit_static"], 1));
  lines.push_back(line);
}

/// The timestep of lowest PSNR, where there are several.
void add_worst_timestep(const json& score, Lines& lines) {
  if (!score.contains("timesteps") || score["timesteps"].size() < 2) return;
  const json& worst = score["worst_timestep"];
  lines.push_back(fmt::format("lowest timestep: frame {}, PSNR {} dB",
                              worst["frame_number"].get<int64_t>(), number_text(worst["psnr"], 2)));
}

/// Of the boxes of each object, where they were given.
void add_objects(const json& score, Lines& lines) {
  if (!score.contains("objects")) return;
  for (const json& object : score["objects"])
    lines.push_back(fmt::format("{}: PSNR {} dB, lowest at frame {}, {} dB",
                                object["name"].get<std::string>(), number_text(object["psnr"], 2),
                                object["worst"]["frame_number"].get<int64_t>(),
                                number_text(object["worst"]["psnr"], 2)));
}

void add_motion(const json& score, Lines& lines) {
  if (score["psnr_dynamic"].is_number())
    lines.push_back(fmt::format("moving pixels {} dB, static pixels {} dB",
                                number_text(score["psnr_dynamic"], 1),
                                number_text(score["psnr_static"], 1)));
  if (score.contains("dynamic_weight_inside"))
    lines.push_back(
        fmt::format("moving regions have {} of the blending weight of dynamic Gaussians, which "
                    "cover {} of the moving pixels",
                    number_text(score["dynamic_weight_inside"], 3),
                    number_text(score["moving_pixels_covered"], 3)));
  if (score["flicker"].is_object())
    lines.push_back(fmt::format("temporal error {}/255, flicker of static pixels {}/255",
                                number_text(score["flicker"]["change_error"], 2),
                                number_text(score["flicker"]["still_deviation"], 2)));
}

}  // namespace

std::string scores_text(const json& scores, ScoreDetail detail) {
  std::string text;
  if (!scores.contains("splits")) return text;
  for (const auto& [split, score] : scores["splits"].items()) {
    text += fmt::format("{}{} ({}): PSNR {} dB, SSIM {}", text.empty() ? "" : "\n",
                        views_text(split), score["per_view"].size(), number_text(score["psnr"], 2),
                        number_text(score["ssim"], 4));
    Lines lines;
    if (const std::string seen = verdict(score); split != "train" && !seen.empty())
      lines.push_back(seen);
    add_structure(score, detail, lines);
    add_novelty(score, lines);
    add_motion(score, lines);
    add_colour_fit(score, lines);
    add_worst_timestep(score, lines);
    add_objects(score, lines);
    for (const std::string& line : lines) text += "\n  " + line;
  }
  return text;
}

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
