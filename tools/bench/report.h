// Points from the results of runs: medians and spreads over seeds by scene, label and step, as JSON
// and CSV; the Pareto front of time and quality, and its knee.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// What is measured in a run, in the order of columns: psnr (dB), ssim, seconds (of training
/// steps), load_seconds (reading the scene, initialising, saving; of runs that ran in one go),
/// evaluate_seconds, bytes (of the model), shipped_bytes (of its Tessera 4D file), num_gaussians,
/// …, fps, peak_device_bytes (of training), psnr_2x (at twice the resolution of training), ….
const std::vector<std::string>& bench_metrics();

/// Runs (recorded_run) → [{scene, split, points: [{label, iterations, n, metrics: {psnr: {median,
/// least, most, count}, …}, devices, errors}]}], in the order of the runs.
nlohmann::json bench_points(const nlohmann::json& runs);
/// Each step at which a run was scored on the way as a run of its own, for bench_points.
nlohmann::json curve_runs(const nlohmann::json& runs);

/// Adds `frontier` (by median seconds and PSNR) and `knee` to every point of every scene.
void mark_pareto_front(nlohmann::json& scenes);

/// A line per point: scene, split, label, iterations, n, each metric with _least and _most,
/// frontier, knee, devices. What is not known is empty.
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

/// A model that took `seconds` (> 0) to train and scores `psnr` dB.
struct TimedScore {
  double seconds = 0, psnr = 0;
};

/// Indices of the points that no other is at least as fast and at least as good as (of equal ones
/// the first), from the fastest to the best.
std::vector<size_t> pareto_front_of(const std::vector<TimedScore>& points);

/// The point of the frontier where more time begins to buy little: the one farthest above the
/// straight line from its fastest to its best point, with log(seconds) and PSNR each scaled to
/// [0, 1] between these two. Nothing where the frontier has fewer than three points or none lies
/// above the line.
std::optional<size_t> knee_of(const std::vector<TimedScore>& points);

}  // namespace tessera
