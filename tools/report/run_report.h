// The data of a run's report, from the files that the run wrote. Files may be missing or be of an
// earlier version; the fields that they would fill are empty then. No file is read here and no
// image is made.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ingest/camera_row.h"
#include "tools/report/svg_chart.h"

namespace tessera {

/// The files of a run; null or empty where there is none.
struct RunRecords {
  nlohmann::json config, metrics;  // RUN/config.json, RUN/metrics.json
  nlohmann::json stages;           // OUT/stages.json of `tessera run`
  std::string log;                 // RUN/log.jsonl
};

/// Over steps, ascending. A training that was resumed from an earlier step has each step once.
struct RunCurves {
  std::vector<ChartPoint> psnr_test, psnr_validation;  // dB
  std::vector<ChartPoint> loss;                        // mean over the steps of a line of the log
  std::vector<ChartPoint> num_static, num_dynamic;     // Gaussians
  std::vector<ChartPoint> bytes;                       // peak of the device's memory so far
};

/// Something that the training did by itself, as a sentence.
struct RunDecision {
  int64_t step = 0;
  std::string text;
};

struct RunWarning {
  std::string stage, text;  // "ingest" or "train"
};

struct ScoredView {
  std::string name, camera;
  double time = 0;  // normalised
  double psnr = 0;  // dB
  std::optional<double> psnr_dynamic, psnr_static;
};

/// A value of the head of the page: "PSNR of moving pixels", "24.1 dB".
struct RunScore {
  std::string name, value;
};

struct StageTime {
  std::string name;
  double seconds = 0;
};

struct RunReport {
  std::string command, version, started, host, cpu, device, preset;
  std::string split;  // of the views: "test", "val" or "train"; "" where nothing is scored
  int64_t steps = 0;
  int64_t num_static = 0, num_dynamic = 0;  // Gaussians of the model
  std::vector<StageTime> stages;            // in their order
  RunCurves curves;
  std::vector<RunScore> scores;
  std::vector<ScoredView> views;  // in the order of the scene
  std::vector<RunDecision> decisions;
  std::vector<RunWarning> warnings;  // each once
  std::vector<CameraRow> cameras;    // of the rig; empty of other captures and of earlier runs
};

RunReport run_report(const RunRecords& records);

/// {version, command, started, host, cpu, device, preset, steps, num_static, num_dynamic, stages
/// [{name, seconds}], curves {psnr_test, psnr_validation, loss, num_static, num_dynamic, bytes:
/// [[step, value]]}, scores {name: value}, split, views [{name, camera, time, psnr, psnr_dynamic,
/// psnr_static}], decisions [{step, text}], warnings [{stage, text}], camera_table as
/// camera_table_json() makes it}.
nlohmann::json to_json(const RunReport& report);

}  // namespace tessera
