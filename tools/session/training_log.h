// Writes a training to log.jsonl, one JSON object a line, and passes its steps on to the session's
// observer.
#pragma once
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "recon4d/training/trainer.h"
#include "tools/session/session_observer.h"

namespace tessera {

class TrainingLog final : public Observer {
 public:
  /// `total` and `first`: steps in all and done before. An existing log is continued, without a
  /// last line that was only half written. Errors: InputError or WriteError, of `event` too.
  TrainingLog(const std::filesystem::path& path, int64_t total, int64_t first,
              SessionObserver& observer);

  void on_step(const StepReport& report) override;
  void on_density(int64_t iteration, const std::string& set, const DensityReport& report) override;
  /// Any other event: {"event": name, …}.
  void event(const std::string& name, nlohmann::json fields);
  const StepReport& last() const { return last_; }

 private:
  static constexpr int64_t kStepsPerLine = 50;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  int64_t total_, first_;
  SessionObserver& observer_;
  StepReport last_;
  StepReport sum_;  // loss, l1, ssim, seconds over the steps of a line
  int64_t steps_ = 0;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace tessera
