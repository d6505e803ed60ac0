// The scores of a clip whose windows were scored one after another, each by a model of its own.
#pragma once
#include <cstdint>
#include <map>
#include <optional>

#include "recon4d/evaluation/evaluate.h"
#include "tools/clip/border_scores.h"

namespace tessera {

class JoinedReport {
 public:
  /// Of a window that follows those before. `origin` and `length`: its time τ is that of the clip
  /// at origin + length · τ.
  void add(EvaluationReport part, double origin, double length);
  /// Of one window as it was added. Else means are over all views; timesteps and objects are those
  /// of all windows, the PSNR of an object by the mean error over its timesteps; the flicker of a
  /// camera is the mean over windows by their pairs of timesteps; colour fits are each window's own
  /// and not named.
  EvaluationReport finish();

 private:
  int64_t parts_ = 0;
  EvaluationReport whole_;  // of the first
  EvaluationReport all_;
  std::map<std::string, ObjectScore> objects_;
  struct Flicker {
    FlickerScore score;
    double pairs = 0;  // of timesteps of one window
  };
  std::map<std::string, Flicker> flicker_;
};

/// {inside, inside_moving, border, border_moving}; null where there is no such pixel.
nlohmann::json to_json(const BorderScore& score);

}  // namespace tessera
