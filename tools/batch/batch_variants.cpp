// Presets or rows of a table, times budgets and steps.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/options/presets.h"
#include "tools/batch/batch.h"
#include "tools/batch/engine.h"
#include "tools/batch/given.h"
#include "tools/session/clock/time_limit.h"

namespace tessera {
namespace {

using nlohmann::json;
using Options = std::map<std::string, std::string>;

constexpr const char* kAblation = "ablation";
constexpr const char* kCheckpointEvery = "checkpoint_every";
constexpr const char* kEvaluateEvery = "evaluate_every";
constexpr const char* kTimeLimit = "time_limit";

struct Column {
  std::string name, preset, label;
  Options options;  // key → text
  json published = json::array();
};

Options read_options(const json& given, const std::string& where) {
  if (!given.is_object())
    throw InputError(fmt::format("{}: expected {{iterations: 500}}, not {}", where, given.dump()));
  Options options;
  for (const auto& [key, value] : given.items()) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '-', '_');
    options[name] = text_of_value(value);
  }
  return options;
}

Column read_preset(const json& entry) {
  if (entry.is_string()) return {entry, entry, "", {}};
  if (!entry.is_object() || !entry.value("preset", json()).is_string())
    throw InputError(
        fmt::format("presets: {} has no `preset`; write a preset's name or {{name: a, preset: "
                    "balanced, options: {{iterations: 500}}}}",
                    entry.dump()));
  const std::string preset = entry["preset"], where = "presets: " + preset;
  check_keys(entry, {"name", "preset", "options"}, where);
  return {checked_name(text_of_value(entry.value("name", json(preset))), "presets"), preset, "",
          read_options(entry.value("options", json::object()), where + ": options")};
}

/// Options of a row go over those of the file.
std::vector<Column> read_table(const json& given) {
  if (given.contains("presets"))
    throw InputError("table: its rows have their presets; take out `presets` or `table`");
  const std::map<std::string, std::string> tables = workflow_tables();
  std::vector<std::string> names;
  for (const auto& [name, text] : tables) names.push_back(name);
  const std::string name = text_of_value(given["table"]);
  check_known(name, names, "table: unknown table");
  const Options above = read_options(given.value("options", json::object()), "options");
  std::vector<Column> columns;
  const json table = json::parse(tables.at(name));
  for (const json& row : table["rows"]) {
    Column column{row["name"], row["preset"], row["label"], above, row["published"]};
    for (const auto& [key, value] : read_options(row["options"], column.name))
      column.options[key] = value;
    columns.push_back(std::move(column));
  }
  return columns;
}

/// With each value of one axis. `end`: of the name; `words`: of the label.
std::vector<Column> multiplied(const std::vector<Column>& columns, const json& given,
                               const char* key, const char* option, const char* end,
                               const char* words) {
  const std::vector<int64_t> values = numbers_at(given, key, 1, json::array());
  if (values.empty()) return columns;
  std::vector<Column> all;
  for (const Column& plain : columns) {
    if (plain.options.contains(option))
      throw InputError(
          fmt::format("{}: {} has {} of its own; take one of them out", key, plain.name, option));
    for (const int64_t value : values) {
      Column column = plain;
      column.name += fmt::format("-{}{}", value, end);
      if (!column.label.empty()) column.label += fmt::format(", {}{}", value, words);
      column.options[option] = fmt::format("{}", value);
      all.push_back(std::move(column));
    }
  }
  return all;
}

std::vector<std::string> known_options() {
  std::vector<std::string> names{kAblation, kCheckpointEvery, kEvaluateEvery, kTimeLimit};
  for (const TrainOption& row : train_option_table()) names.emplace_back(row.key);
  return names;
}

int64_t steps_of(const std::string& key, const std::string& text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string::npos || text.size() > 15)
    throw InputError(fmt::format("{}: '{}' is no number of steps", key, text));
  return std::stoll(text);
}

/// Errors: InputError: as a training of these options.
BatchVariant checked(const Column& column) {
  static const std::vector<std::string> known = known_options();
  BatchVariant variant{column.name, {}, "", column.label, column.published};
  TrainArguments& arguments = variant.arguments;
  arguments.preset = column.preset;
  arguments.evaluate_every = kNeverEvaluate;  // a job of its own scores the model
  try {
    for (const auto& [key, text] : column.options) {
      if (key == "seed") throw InputError("seed: is no option of a preset; use `seeds`");
      check_known(key, known, "unknown option");
      if (key == kAblation)
        arguments.ablation = text;
      else if (key == kCheckpointEvery)
        arguments.checkpoint_every = steps_of(key, text);
      else if (key == kEvaluateEvery)
        arguments.evaluate_every = text == kNever ? kNeverEvaluate : steps_of(key, text);
      else if (key == kTimeLimit)
        parse_duration(variant.time_limit = text);
      else
        arguments.given[key] = text;
    }
    resolve_options(arguments, SceneFacts{});
  } catch (const InputError& error) {
    throw InputError(fmt::format("presets: {}: {}", column.name, error.what()));
  }
  return variant;
}

}  // namespace

std::vector<BatchVariant> read_variants(const json& given) {
  std::vector<Column> columns;
  if (!given.value("table", json()).is_null()) {
    columns = read_table(given);
  } else {
    if (given.contains("options"))
      throw InputError("options: go with `table`; each of `presets` has options of its own");
    for (const json& entry : list_at(given, "presets", {TrainArguments{}.preset}))
      columns.push_back(read_preset(entry));
  }
  columns = multiplied(columns, given, "budgets", "max_gaussians", "", " Gaussians");
  columns = multiplied(columns, given, "steps", "iterations", "-steps", " steps");
  std::set<std::string> names;
  std::vector<BatchVariant> variants;
  for (Column& column : columns) {
    if (!names.insert(column.name).second)
      throw InputError(
          fmt::format("presets: two are named '{}'; give one of them another `name`", column.name));
    if (given.value("deterministic", false)) column.options.emplace("deterministic", "true");
    variants.push_back(checked(column));
  }
  return variants;
}

}  // namespace tessera
