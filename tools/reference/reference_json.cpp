// The options of the program as one JSON object, for programs that call it.
#include <nlohmann/json.hpp>

#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"
#include "tools/cli/option_reference.h"
#include "tools/reference/reference.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

using nlohmann::json;

const char* type_of(const TrainOption& row) {
  if (row.is_switch()) return "switch";
  if (!row.choices().empty()) return "choice";
  if (std::holds_alternative<std::string TrainOptions::*>(row.member)) return "text";
  return std::holds_alternative<double TrainOptions::*>(row.member) ? "number" : "whole";
}

json row_json(const TrainOption& row) {
  json defaults = json::object();
  for (const Preset& preset : presets()) {
    TrainOptions options;
    apply_preset(options, preset.name);
    defaults[preset.name] = to_json(option_value(options, row));
  }
  json object = {{"key", row.key},         {"type", type_of(row)}, {"unit", name_of(row.unit)},
                 {"doc", row.doc},         {"group", row.group},   {"source", row.source},
                 {"example", row.example}, {"defaults", defaults}, {"choices", row.choices()}};
  if (!option_range(row).empty()) object["range"] = {row.low, row.high};
  if (const std::string rig = rig_default(row); !rig.empty()) object["default_on_rigs"] = rig;
  return object;
}

json option_json(const OptionReference& option) {
  return {{"names", option.names},         {"placeholder", option.placeholder},
          {"choices", option.choices},     {"doc", option.doc},
          {"default", option.defaults},    {"required", option.required},
          {"argument", option.is_argument}};
}

}  // namespace

json reference_json(const std::vector<CommandReference>& commands) {
  json result = {
      {"version", kVersionText}, {"commands", json::array()}, {"train_options", json::array()}};
  for (const CommandReference& command : commands) {
    json object = {{"name", command.name},
                   {"doc", command.doc},
                   {"options", json::array()},
                   {"has_train_options", false}};
    for (const OptionReference& option : command.options)
      if (option.row == nullptr)
        object["options"].push_back(option_json(option));
      else
        object["has_train_options"] = true;
    result["commands"].push_back(object);
  }
  for (const TrainOption& row : train_option_table())
    result["train_options"].push_back(row_json(row));
  return result;
}

}  // namespace tessera
