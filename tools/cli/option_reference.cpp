// Rows of the option table are recognised by their name and group; the text of other options comes
// from CLI11.
#include "tools/cli/option_reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "recon4d/options/presets.h"

namespace tessera {
namespace {

const TrainOption* row_of(const CLI::Option& option) {
  for (const TrainOption& row : train_option_table())
    if (option.get_group() == row.group && option.check_lname(dashed(row.key))) return &row;
  return nullptr;
}

bool takes_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

std::string placeholder_of(const CLI::Option& option) {
  if (!takes_value(option)) return "";
  constexpr std::pair<const char*, const char*> kNamed[] = {
      {"out", "DIR"},     {"config", "FILE"}, {"masks", "DIR"},   {"offsets", "FILE"},
      {"lpips", "FILE"},  {"model", "FILE"},  {"preset", "NAME"}, {"ablation", "NAME"},
      {"format", "NAME"}, {"scene", "DIR"},   {"size", "WxH"}};
  for (const auto& [name, placeholder] : kNamed)
    if (option.check_lname(name)) return placeholder;
  const std::string type = option.get_type_name();
  if (type.starts_with("UINT") || type.starts_with("INT")) return "N";
  if (type.starts_with("FLOAT")) return "X";
  return type.empty() || type.starts_with("TEXT") ? "VALUE" : type.substr(0, type.find(':'));
}

std::string default_of(const CLI::Option& option) {
  const bool ends_program =
      option.check_lname("help") || option.check_lname("help-all") || option.check_lname("version");
  if (option.get_required() || ends_program) return "";
  if (!option.get_fnames().empty()) return "";  // "--no-…" is there: its text says the default
  if (!takes_value(option)) return "no";
  // lists come in brackets, empty ones differently from version to version of CLI11
  std::string text = option.get_default_str();
  if (text == "\"\"" || text == "{}") return "";
  if (text.starts_with('[') && text.ends_with(']')) text = text.substr(1, text.size() - 2);
  return text;
}

/// The first words of the indented lines below a description: what the value may be.
std::vector<std::string> listed_choices(const std::string& doc) {
  std::vector<std::string> choices;
  std::istringstream lines(doc);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("    ")) {
      std::istringstream words(line);
      words >> choices.emplace_back();
    }
  return choices;
}

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

/// A value that several presets share.
struct PresetDefault {
  std::string value;
  std::vector<std::string> presets;
};

/// The default in each preset, the value of `balanced` first. Values that presets use for rigs only
/// are not among them.
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

}  // namespace

std::string first_line(const std::string& doc) {
  std::string line = doc.substr(0, doc.find('\n'));
  if (line.ends_with(':')) line.pop_back();  // a list follows
  return line;
}

OptionReference option_reference(const CLI::Option& option) {
  OptionReference entry;
  entry.group = option.get_group();
  entry.required = option.get_required();
  entry.is_argument = option.get_positional();
  entry.row = row_of(option);
  if (const TrainOption* row = entry.row) {
    entry.names = {"--" + dashed(row->key)};
    if (row->is_switch()) entry.names.push_back("--no-" + dashed(row->key));
    entry.placeholder = option_placeholder(*row);
    for (const char* choice : row->choices()) entry.choices.emplace_back(choice);
    entry.doc = row->doc;
    entry.defaults = default_text(*row);
    return entry;
  }
  if (entry.is_argument) entry.names.push_back(option.get_name(true, false));
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  entry.placeholder = entry.is_argument ? "" : placeholder_of(option);
  entry.doc = option.get_description();
  entry.choices = listed_choices(entry.doc);
  entry.defaults = default_of(option);
  return entry;
}

CommandReference command_reference(const CLI::App& command) {
  CommandReference reference{command.get_name(), command.get_description(), {}};
  for (const CLI::Option* option : command.get_options())
    if (!option->get_group().empty()) reference.options.push_back(option_reference(*option));
  std::stable_partition(reference.options.begin(), reference.options.end(),
                        [](const OptionReference& option) { return option.is_argument; });
  return reference;
}

std::vector<CommandReference> program_reference(const CLI::App& app) {
  std::vector<CommandReference> commands;
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_group().empty()) commands.push_back(command_reference(*command));
  return commands;
}

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
  if (key == "opacity_weight" || key == "scale_weight")
    return fmt::format("{:g} by the number of cameras", kRigWeight);
  if (key == "lr_sh_rest") return fmt::format("in proportion below {} cameras", kManyCameras);
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
