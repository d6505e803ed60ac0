// Adds up what the windows' own trainings have reported.
#include "tools/windows/windows_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/cli/terminal.h"
#include "tools/live/earlier_training.h"
#include "tools/session/run_folder.h"

namespace tessera {

using nlohmann::json;

json windows_result(const WindowsFolder& folder) {
  const WindowsPlan plan = folder.exists() ? folder.read() : WindowsPlan{};
  json parts = json::array();
  int64_t dynamic = 0, most = 0, bytes = 0;
  json fixed = recorded_result(RunFolder{folder.static_run()});
  const int64_t statics = fixed.is_object() ? fixed.value("num_static", int64_t{0}) : 0;
  double seconds = fixed.is_object() ? fixed.value("seconds", 0.0) : 0;
  for (int64_t i = 0; i < int64_t(plan.windows.size()); ++i) {
    json part = recorded_result(RunFolder{folder.window_run(i)});
    if (part.is_object()) {
      const auto count = part.value("num_dynamic", int64_t{0});
      dynamic += count;
      most = std::max(most, count);
      seconds += part.value("seconds", 0.0);
      bytes += part.value("bytes", int64_t{0});
    }
    parts.push_back(std::move(part));
  }
  return {{"windows", plan.windows.size()},
          {"folder", folder.root.string()},
          {"finished", !plan.windows.empty() && folder.missing(plan).empty()},
          {"num_static", statics},
          {"num_dynamic", dynamic},
          {"num_gaussians", statics + dynamic},
          {"bytes", bytes},
          {"peak_gaussians", statics + most},
          {"seconds", seconds},
          {"static", std::move(fixed)},
          {"parts", std::move(parts)}};
}

std::string windows_text(const json& result) {
  const auto windows = result["windows"].get<int64_t>();
  if (!result["finished"].get<bool>())
    return fmt::format("stopped before all {} windows were trained; repeat the command to go on",
                       windows);
  return fmt::format(
      "{} windows in {}: {} static Gaussians that they share, {} dynamic ones, at most {} at a "
      "time; folder {}",
      windows, duration_text(result["seconds"]), result["num_static"].get<int64_t>(),
      result["num_dynamic"].get<int64_t>(), result["peak_gaussians"].get<int64_t>(),
      result["folder"].get<std::string>());
}

}  // namespace tessera
