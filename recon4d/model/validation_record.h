// The results of the checks of a training on its validation frames, which a checkpoint stores.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

namespace tessera {

/// What a training has learnt from its checks; a checkpoint keeps it.
struct ValidationRecord {
  int64_t checks = 0;          // so far
  int64_t last_iteration = 0;  // of the last check
  double last_psnr = 0;        // dB, mean over the validation frames, 8 bit
  int64_t best_iteration = 0;  // 0: no check yet
  double best_psnr = 0;        // of the best check
  int64_t best_gaussians = 0;  // of its model
  double peak_psnr = 0;        // the best that any check has seen, also of larger models
  double best_seconds = 0;     // of training until then
  double reference_psnr = 0;   // what the next gain is counted from
  int64_t without_gain = 0;    // checks since the reference
  bool stopped = false;        // patience has run out

  /// A gain counts towards patience when it is larger, dB.
  static constexpr double kLeastGain = 0.02;

  /// Takes the score of a model after `iteration` steps; whether it is the best so far: of the
  /// highest PSNR, or, with `within_db` > 0, of the fewest Gaussians among those within so many dB
  /// of the peak.
  bool add(int64_t iteration, double seconds, double psnr, int64_t gaussians, int64_t patience,
           double within_db = 0);
  /// The best is to be found anew: models so far are larger than what may be shipped.
  void restart();
};
nlohmann::json to_json(const ValidationRecord& record);
/// Errors: nlohmann::json::exception.
ValidationRecord validation_record_from_json(const nlohmann::json& json);

}  // namespace tessera
