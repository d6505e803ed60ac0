// The report of a batch as one object: runs with their scores, medians and spreads by scene and
// preset, failures, versions, devices, options.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "tools/batch/batch_folder.h"

namespace tessera {

/// {title, summary, counts {runs, done, failed, missing, scenes, whole_scenes}, versions, devices,
/// variants [{name, preset, options}], captures [{name, path, ingest}], scenes (bench_points with
/// Pareto front and knee, over the requested runs that have scores), runs [{scene, preset, seed,
/// state, folder (below OUT), psnr, ssim, seconds, num_gaussians, bytes, shipped_bytes, player
/// (below OUT), error, iterations, …}], earlier_runs (as runs: finished, but not of this request;
/// no other entry counts them), failures [{…, line}], notes}. A file that is damaged is a note.
nlohmann::json batch_report(const BatchFolder& batch);

}  // namespace tessera
