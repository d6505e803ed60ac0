// What help, reference pages and man pages write about one row of the option table.
#pragma once
#include <string>
#include <vector>

#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// "--max-gaussians", and "--carve, --no-carve" of a switch.
std::string option_names(const TrainOption& option);
/// The placeholder of a value: "N", "X", "SIZE", "{pair,velocity}"; empty for a switch.
std::string option_placeholder(const TrainOption& option);
/// "0 to 1"; empty where the type alone limits a value.
std::string option_range(const TrainOption& option);

/// A value that several presets share.
struct PresetDefault {
  std::string value;
  std::vector<std::string> presets;
};
/// The default in each preset, the value of `balanced` first. Values that presets use for rigs only
/// are not among them.
std::vector<PresetDefault> preset_defaults(const TrainOption& option);
/// What `balanced` uses for a rig (SceneFacts::rig); empty where it is the same as elsewhere.
std::string rig_default(const TrainOption& option);
/// Both in one line: "7000; fast 2000; rigs 9000".
std::string default_text(const TrainOption& option);

/// The key as an option is typed, without dashes in front: "max-gaussians".
std::string dashed(std::string key);

}  // namespace tessera
