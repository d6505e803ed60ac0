// What the trainings of a clip's windows have come to.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/session/windows_folder.h"

namespace tessera {

/// `windows` (number), `finished`, `folder`, `static` and `parts` (results of the trainings),
/// `num_static`, `num_dynamic` and `num_gaussians` (sums), `bytes` (of the models' files),
/// `peak_gaussians` (of a window with the static set), `seconds` (sum). A folder without a plan has
/// no windows.
nlohmann::json windows_result(const WindowsFolder& folder);

/// In lines for a person; of a result of train_windows.
std::string windows_text(const nlohmann::json& result);

}  // namespace tessera
