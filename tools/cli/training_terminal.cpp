// Formats the lines and the note beside the progress bar. tools/session/training_log.h writes the
// log of the run folder.
#include "tools/cli/training_terminal.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/session/held_out_scores.h"

namespace tessera {
namespace {

/// "" without validation.
std::string validation_text(const nlohmann::json& checks) {
  if (checks.is_null()) return "";
  return fmt::format(
      "the model is that of step {} ({}), best of {} checks: PSNR {:.2f} dB on {} "
      "validation views{}",
      checks["best_iteration"].get<int64_t>(), clock_time(checks["best_seconds"]),
      checks["checks"].get<int64_t>(), checks["best_psnr"].get<double>(),
      checks["frames"].get<int64_t>(),
      checks["stopped"].get<bool>()
          ? fmt::format("; stopped at step {}", checks["stop_iteration"].get<int64_t>())
          : "");
}

}  // namespace

void TrainingTerminal::on_message(const std::string& line) {
  say(line);
}

void TrainingTerminal::on_warning(const std::string& line) {
  warn(line);
}

void TrainingTerminal::on_cuda_unused(const std::string& reason) {
  warn_of_unused_cuda(reason);
}

void TrainingTerminal::on_step(const SessionStep& step) {
  const StepReport& report = step.report;
  if (!bar_) bar_.emplace("train");
  bar_->update(report.iteration, step.total,
               fmt::format("loss {:.4f}, {} static + {} dynamic, {:.1f} steps/s", report.loss,
                           report.num_static, report.num_dynamic, step.steps_per_second),
               step.first);
}

bool TrainingTerminal::must_stop() {
  return interrupted();
}

ScoreDetail score_detail() {
  return is_verbose() ? ScoreDetail::kAll : ScoreDetail::kUsual;
}

std::string training_text(const nlohmann::json& result) {
  const std::string text =
      fmt::format("{} steps in {}, {} static + {} dynamic Gaussians, model {}",
                  result["iterations"].get<int64_t>(), clock_time(result["seconds"]),
                  result["num_static"].get<int64_t>(), result["num_dynamic"].get<int64_t>(),
                  result["model"].get<std::string>());
  const std::string checks = validation_text(result["validation"]);
  const std::string scores = scores_text(result["scores"], score_detail());
  return text + (checks.empty() ? "" : "\n" + checks) + (scores.empty() ? "" : "\n" + scores);
}

}  // namespace tessera
