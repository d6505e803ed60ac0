// Texts are made from the rows and from the presets as they are applied; none is stored.
#include "tools/cli/option_text.h"
#include "recon4d/options/presets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tessera {
namespace {

std::string short_text(const OptionValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:.4g}", *number);
  if (const auto* truth = std::get_if<bool>(&value)) return *truth ? "yes" : "no";
  return plain_text(value);
}

std::string limit_text(double limit) {
  return limit == double(int64_t(limit)) && limit < 1e6 ? fmt::format("{:.0f}", limit)
                                                        : fmt::format("{:g}", limit);
}

std::string value_in(const TrainOption& option, const std::string& preset,
                     const SceneFacts& facts = {}) {
  TrainOptions options;
  apply_preset(options, preset, facts);
  return short_text(option_value(options, option));
}

}  // namespace

std::string dashed(std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  return key;
}

std::string option_names(const TrainOption& option) {
  const std::string name = dashed(option.key);
  return option.is_switch() ? fmt::format("--{0}, --no-{0}", name) : "--" + name;
}

std::string option_placeholder(const TrainOption& option) {
  if (option.is_switch()) return "";
  if (const auto choices = option.choices(); !choices.empty())
    return fmt::format("{{{}}}", fmt::join(choices, ","));
  if (std::holds_alternative<std::string TrainOptions::*>(option.member)) return "TEXT";
  if (option.unit == Unit::kBytes) return "SIZE";
  return std::holds_alternative<double TrainOptions::*>(option.member) ? "X" : "N";
}

std::string option_range(const TrainOption& option) {
  if (option.is_switch() || !option.choices().empty() ||
      std::holds_alternative<std::string TrainOptions::*>(option.member))
    return "";
  return fmt::format("{} to {}", limit_text(option.low), limit_text(option.high));
}

std::vector<PresetDefault> preset_defaults(const TrainOption& option) {
  std::vector<PresetDefault> defaults{{value_in(option, "balanced"), {}}};
  for (const Preset& preset : presets()) {
    const std::string value = value_in(option, preset.name);
    auto place = std::find_if(defaults.begin(), defaults.end(),
                              [&](const PresetDefault& d) { return d.value == value; });
    if (place == defaults.end()) place = defaults.insert(place, {value, {}});
    place->presets.push_back(preset.name);
  }
  return defaults;
}

std::string rig_default(const TrainOption& option) {
  // 101 frames: a clip length is 100 frame intervals
  const SceneFacts rig{.cameras = 10, .timesteps = 101, .extent = 1};
  const std::string on_rig = value_in(option, "balanced", rig);
  if (on_rig == value_in(option, "balanced")) return "";
  const auto balanced = std::find_if(presets().begin(), presets().end(),
                                     [](const Preset& p) { return p.name == "balanced"; });
  const FrameRates& rates = balanced->rig_rates;
  const std::string key = option.key;
  if (key == "init_time_scale") return fmt::format("{:g} frames", rates.extent_frames);
  if (key == "lr_velocity") return fmt::format("{:g} scene extents a frame", rates.velocity_rate);
  if (key == "lr_mean_time") return fmt::format("{:g} frames", rates.mean_time_rate);
  return on_rig;
}

std::string default_text(const TrainOption& option) {
  const std::vector<PresetDefault> defaults = preset_defaults(option);
  std::string text = defaults.front().value;
  for (size_t i = 1; i < defaults.size(); ++i)
    text += fmt::format("; {} {}", fmt::join(defaults[i].presets, ", "), defaults[i].value);
  if (const std::string rig = rig_default(option); !rig.empty()) text += "; rigs " + rig;
  const std::string single = value_in(option, "balanced", {.single_view = true});
  if (single != value_in(option, "balanced")) text += "; one view a timestep " + single;
  return text;
}

}  // namespace tessera
