// Options as a JSON object of key: value, as in config.json, --config and checkpoints.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "recon4d/options/train_options.h"

namespace tessera {

nlohmann::json to_json(const OptionValue& value);
nlohmann::json to_json(const TrainOptions& options);
/// Errors: InputError: not an object, and as set_option.
TrainOptions train_options_from_json(const nlohmann::json& json);
/// Errors: InputError: the value is null, a list or an object, and as set_option.
void set_option_from_json(TrainOptions& options, const std::string& key,
                          const nlohmann::json& value);

}  // namespace tessera
