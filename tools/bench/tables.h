// The tables of `tessera bench --table`: rows as data, with the published figures.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// Figures that others measured, on other hardware.
struct Published {
  std::string source;                     // method, whose measurement, over what, device
  std::string scene;                      // a dataset's name of the scene; empty: a mean
  std::map<std::string, double> figures;  // by names of bench_metrics
};

/// Whether a scene in a folder of this name is meant: "lego" is dnerf_lego.
bool is_of_scene(const Published& published, const std::string& folder);

enum class SceneKind { kAny, kStill, kMoving };

struct BenchRow {
  std::string name;
  std::string preset;         // empty: 3dgs for still scenes, faster-gs for moving ones
  std::string ablation;       // over the preset; or empty
  OptionOverrides overrides;  // over both and over what is typed
  SceneKind kind = SceneKind::kAny;
  std::string count_of = {};  // max_gaussians is what that row ended with
  std::vector<Published> published = {};
};

struct BenchTable {
  std::string name, doc;
  SceneKind kind = SceneKind::kAny;
  std::vector<std::string> columns;  // of bench_metrics
  std::vector<double> scales;        // of the training resolution, scored each
  std::vector<BenchRow> rows;
};

const std::vector<BenchTable>& bench_tables();
/// Errors: InputError naming the nearest known name.
const BenchTable& bench_table(const std::string& name);

/// The row's, or the one of such scenes.
std::string row_preset(const BenchRow& row, bool still_scene);
/// Names the folders of the row's runs: preset, ablation and overrides, so that equal rows of
/// several tables share them.
std::string row_label(const BenchRow& row, bool still_scene);

}  // namespace tessera
