// The choice of the best validation check, and the end of patience.
#include "recon4d/model/validation_record.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {

bool ValidationRecord::add(int64_t iteration, double seconds, double psnr, int64_t gaussians,
                           int64_t patience, double within_db) {
  const bool first = best_iteration == 0;
  peak_psnr = checks == 0 ? psnr : std::max(peak_psnr, psnr);
  ++checks;
  last_iteration = iteration;
  last_psnr = psnr;
  if (first || psnr > reference_psnr + kLeastGain) {
    reference_psnr = psnr;
    without_gain = 0;
  } else
    ++without_gain;
  stopped = patience > 0 && without_gain >= patience;
  const double least = peak_psnr - within_db;
  const bool smaller = within_db > 0 && best_psnr >= least
                           ? psnr >= least && gaussians < best_gaussians
                           : psnr > best_psnr;
  if (!first && !smaller) return false;
  best_iteration = iteration;
  best_psnr = psnr;
  best_seconds = seconds;
  best_gaussians = gaussians;
  return true;
}

void ValidationRecord::restart() {
  best_iteration = 0;
  best_gaussians = 0;
  without_gain = 0;
  stopped = false;
}

nlohmann::json to_json(const ValidationRecord& record) {
  return {{"checks", record.checks},
          {"last_iteration", record.last_iteration},
          {"last_psnr", record.last_psnr},
          {"best_iteration", record.best_iteration},
          {"best_psnr", record.best_psnr},
          {"best_seconds", record.best_seconds},
          {"best_gaussians", record.best_gaussians},
          {"peak_psnr", record.peak_psnr},
          {"reference_psnr", record.reference_psnr},
          {"without_gain", record.without_gain},
          {"stopped", record.stopped}};
}

ValidationRecord validation_record_from_json(const nlohmann::json& json) {
  ValidationRecord record;
  record.checks = json.at("checks");
  record.last_iteration = json.at("last_iteration");
  record.last_psnr = json.at("last_psnr");
  record.best_iteration = json.at("best_iteration");
  record.best_psnr = json.at("best_psnr");
  record.best_seconds = json.at("best_seconds");
  record.best_gaussians = json.value("best_gaussians", int64_t{0});
  record.peak_psnr = json.value("peak_psnr", record.best_psnr);
  record.reference_psnr = json.at("reference_psnr");
  record.without_gain = json.at("without_gain");
  record.stopped = json.at("stopped");
  return record;
}

}  // namespace tessera
