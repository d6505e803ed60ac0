// Tables of a batch's page with presets as columns; the best of each row is bold.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

/// PSNR of every scene, with the time of training and the size of the model below it, and the means
/// over the scenes that all presets have a score of. `report`: batch_report.
std::string scenes_table(const nlohmann::json& report);

/// All that is measured of one of the report's scenes, the steps of its trainings, and links to its
/// players.
std::string scene_table(const nlohmann::json& report, const nlohmann::json& scene);

}  // namespace tessera
