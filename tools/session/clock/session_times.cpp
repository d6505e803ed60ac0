// Sums times and converts them to JSON.
#include "tools/session/clock/session_times.h"

#include <nlohmann/json.hpp>

namespace tessera {

nlohmann::json WallSplit::json() const {
  constexpr const char* kNames[kKinds] = {"load",  "device", "cloud",     "trial",    "init",
                                          "steps", "unseen", "decisions", "evaluate", "save"};
  nlohmann::json object = nlohmann::json::object();
  for (size_t kind = 0; kind < kKinds; ++kind) object[kNames[kind]] = seconds_[kind];
  return object;
}

void StageLog::add(const std::array<StageTotals, kStages>& before) {
  const std::array<StageTotals, kStages>& after = clock_.totals();
  peak_ = memory_.peak_bytes();
  for (size_t s = 0; s < kStages; ++s) {
    sum_[s].seconds += after[s].seconds - before[s].seconds;
    sum_[s].bytes += after[s].bytes - before[s].bytes;
  }
}

void StageLog::add_to(nlohmann::json& result) const {
  result["peak_device_bytes"] = peak_;
  for (size_t s = 0; s < kStages; ++s) {
    const StageTotals& t = sum_[s];
    result["stage_ms"][kStageNames[s]] = 1000 * t.seconds;
    result["stage_gbytes"][kStageNames[s]] = t.bytes / 1e9;
    result["stage_gb_per_s"][kStageNames[s]] = t.seconds > 0 ? t.bytes / 1e9 / t.seconds : 0;
  }
}

}  // namespace tessera
