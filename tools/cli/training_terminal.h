// Shows a training session on the terminal: messages, a progress bar, and a stop on Ctrl-C.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "tools/cli/terminal.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/session_observer.h"

namespace tessera {

class TrainingTerminal final : public SessionObserver {
 public:
  void on_message(const std::string& line) override;
  void on_warning(const std::string& line) override;
  void on_cuda_unused(const std::string& reason) override;
  void on_step(const SessionStep& step) override;
  bool must_stop() override;

 private:
  std::optional<ProgressBar> bar_;  // from the first step on
};

/// All scores with --verbose.
ScoreDetail score_detail();

/// What train_session returned, in two or three lines for a person.
std::string training_text(const nlohmann::json& result);

}  // namespace tessera
