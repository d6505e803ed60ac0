// Conversion of options to JSON and from JSON.
#include "recon4d/options/train_options_json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

OptionValue value_from_json(const std::string& key, const json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number_unsigned() && value.get<uint64_t>() > uint64_t(INT64_MAX))
    return value.get<double>();
  if (value.is_number_integer()) return value.get<int64_t>();
  if (value.is_number()) return value.get<double>();
  if (value.is_string()) return value.get<std::string>();
  throw InputError(
      fmt::format("option '{}' is {}, expected a number, true, false or text", key, value.dump()));
}

}  // namespace

json to_json(const OptionValue& value) {
  return std::visit([](const auto& held) { return json(held); }, value);
}

json to_json(const TrainOptions& options) {
  json object = json::object();
  for (const TrainOption& option : train_option_table())
    object[option.key] = to_json(option_value(options, option));
  return object;
}

TrainOptions train_options_from_json(const json& object) {
  if (!object.is_object()) throw InputError("options must be a JSON object of key: value");
  TrainOptions options;
  for (const auto& [key, value] : object.items()) set_option_from_json(options, key, value);
  return options;
}

void set_option_from_json(TrainOptions& options, const std::string& key, const json& value) {
  set_option(options, key, value_from_json(key, value));
}

}  // namespace tessera
