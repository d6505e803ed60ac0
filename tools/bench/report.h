// What: results of cells → points: medians and spreads over seeds, by scene, label and step; as
//       JSON and CSV.
// Not: running cells (bench/run.h), images (bench/chart.h) or tables for people
//      (bench/table_text.h).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tessera {

/// What is measured in a cell, in the order of columns: psnr (dB), ssim, seconds (of training
/// steps), load_seconds (reading the scene, initialising, saving; of cells that ran in one go),
/// evaluate_seconds, bytes (of the model), shipped_bytes (of its Tessera 4D file), num_gaussians,
/// …, fps, peak_device_bytes (of training), psnr_2x (at twice the resolution of training), ….
const std::vector<std::string>& bench_metrics();

/// Cells (recorded_cell) → [{scene, split, points: [{label, iterations, n, metrics: {psnr: {median,
/// least, most, count}, …}, devices, errors}]}], in the order of the cells.
nlohmann::json bench_points(const nlohmann::json& cells);
/// Each step at which a cell was scored on the way as a cell of its own, for bench_points.
nlohmann::json curve_cells(const nlohmann::json& cells);

/// Adds `frontier` (by median seconds and PSNR) and `knee` to every point of every scene.
void mark_frontier(nlohmann::json& scenes);

/// A line per point: scene, split, label, iterations, n, each metric with _least and _most,
/// frontier, knee, devices. What is not known is empty.
std::string csv_of(const nlohmann::json& scenes);

/// Sorted and without repeats: what the cells were run on.
std::vector<std::string> devices_of(const nlohmann::json& cells);

}  // namespace tessera
