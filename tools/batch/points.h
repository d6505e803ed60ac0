// Points from the results of runs: medians and spreads over seeds by scene, label and step, as JSON
// and CSV.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// What is measured in a run, in the order of columns: psnr, psnr_dynamic (dB), ssim, lpips,
/// seconds (of steps and decisions of the training), command_seconds (of all stages),
/// num_gaussians, …, bytes (of the model), shipped_bytes (of its Tessera 4D file),
/// peak_device_bytes (of training).
const std::vector<std::string>& point_metrics();

/// Runs {scene, split, label, iterations, seed, status, device, error, metrics} → [{scene, split,
/// points: [{label, iterations, n, metrics: {psnr: {median, least, most, count}, …}, devices,
/// errors}]}], in the order of the runs.
nlohmann::json points_of(const nlohmann::json& runs);
/// A line per point: scene, split, label, iterations, n, each metric with _least and _most,
/// devices. What is not known is empty.
std::string csv_of(const nlohmann::json& scenes);

/// Sorted and without repeats: what the runs were run on.
std::vector<std::string> devices_of(const nlohmann::json& runs);

/// Of the seeds of a run. Of an even number the median is the mean of the middle two.
struct Spread {
  double median = 0, least = 0, most = 0;
  int64_t count = 0;
};

/// Values that are not finite do not count. Nothing where none is left.
std::optional<Spread> spread_of(std::vector<double> values);

}  // namespace tessera
