// The model is chosen by validation views, and then reduced to its limits.
#include "tools/session/session_results.h"

#include <fmt/format.h>

#include <fstream>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "recon4d/model/exposure.h"
#include "tools/session/held_out_scores.h"

namespace tessera {
namespace {

using nlohmann::json;

json validation_result(const TrainState& state, const Validation& validation) {
  if (!validation.on()) return nullptr;
  json result = to_json(validation.record());
  result["frames"] = validation.frames();
  result["stop_iteration"] = state.iteration;
  result["stop_seconds"] = state.seconds;
  return result;
}

json exposure_result(const TrainState& state, const TrainOptions& options) {
  const std::vector<ColourMap<double>> maps = colour_maps_of(state.exposure);
  if (maps.empty()) return nullptr;
  Vec3<double> least = channel_response(maps.front()), most = least;
  for (const ColourMap<double>& map : maps) {
    const Vec3<double> gain = channel_response(map);
    least = glm::min(least, gain);
    most = glm::max(most, gain);
  }
  return {{"by", name_of(options.exposure)},
          {"count", maps.size()},
          {"smallest", {least[0], least[1], least[2]}},
          {"largest", {most[0], most[1], most[2]}}};
}

SizeLimit size_limit(const TrainOptions& options, const Validation& validation,
                     const ShippedBytes& shipped_bytes) {
  SizeLimit limit;
  limit.gaussians = options.max_gaussians;
  limit.bytes = options.max_bytes;
  limit.shipped_bytes = shipped_bytes;
  if (options.within_db > 0) limit.least_psnr = validation.record().peak_psnr - options.within_db;
  limit.psnr = [&validation](const GaussianModel& model) { return validation.psnr(model); };
  return limit;
}

struct Stopped {};

/// PSNR and SSIM of each split: {"test": {"psnr", "ssim"}}.
json summary_of(const json& scores) {
  json summary = json::object();
  if (scores.contains("splits"))
    for (const auto& [split, of_split] : scores["splits"].items())
      summary[split] = {{"psnr", of_split["psnr"]}, {"ssim", of_split["ssim"]}};
  return summary;
}

}  // namespace

bool was_scored(const std::filesystem::path& log, int64_t step) {
  std::ifstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    const json event = json::parse(line, nullptr, false);
    if (event.is_object() && event.value("event", "") == "evaluation" &&
        event.value("iteration", int64_t{-1}) == step)
      return true;
  }
  return false;
}

std::optional<GaussianModel> shipped_model(Trainer& trainer, const TrainOptions& options,
                                           const Validation& validation, Backend& backend,
                                           const ShippedBytes& shipped_bytes, bool is_final) {
  const bool fits = is_final && prunes_after_growth(options),
             is_beside = is_final && trainer.state().static_is_frozen;
  if (validation.best() == nullptr && !fits && !is_beside) return std::nullopt;
  GaussianModel best =
      validation.best() != nullptr ? validation.shipped() : trainer.host_model().clone_values();
  if (is_beside) best = without_still_dynamic(backend, best, trainer.sample_frames());
  if (!fits) return best;
  SizeLimit limit = size_limit(options, validation, shipped_bytes);
  limit.static_is_frozen = trainer.state().static_is_frozen;
  return fit_to_limit(limit, backend, best, trainer.sample_frames());
}

json training_result(const TrainState& state, const TrainOptions& options,
                     const Validation& validation, const GaussianModel& shipped) {
  return {{"seconds", state.seconds},
          {"iterations", state.iteration},
          {"total_iterations", options.iterations},
          {"num_gaussians", shipped.count()},
          {"num_static", shipped.static_set.count()},
          {"num_dynamic", shipped.dynamic_set.count()},
          {"validation", validation_result(state, validation)},
          {"exposure", exposure_result(state, options)}};
}

bool SessionScores::score(Backend& backend, const Scene& scene, const ScoredModel& scored,
                          const std::function<bool()>& stop, TrainingLog& log,
                          SessionObserver& observer) {
  try {
    last_ = score_splits(
        backend, scored.model, scene, held_out_splits(scene),
        [&](const Frame&, const RenderedImage&, const ViewScore&, int64_t, int64_t) {
          if (stop()) throw Stopped();
        },
        scored.is_complete ? EvaluateOptions{} : brief_scores());
  } catch (const Stopped&) {
    return false;
  }
  const json summary = summary_of(last_);
  for (const auto& [split, of_split] : summary.items())
    observer.on_message(fmt::format("step {}: {}: PSNR {} dB, {} Gaussians", scored.step,
                                    views_text(split), number_text(of_split["psnr"], 2),
                                    scored.model.count()));
  log.event(scored.event, {{"iteration", scored.step},
                           {"seconds", scored.seconds},
                           {"num_gaussians", scored.model.count()},
                           {"splits", summary}});
  return true;
}

}  // namespace tessera
