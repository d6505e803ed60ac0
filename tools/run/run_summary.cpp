// Formats the summary of a run from its JSON object.
#include "tools/run/run_summary.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "tools/cli/background_program.h"
#include "tools/cli/terminal.h"
#include "tools/export/player_files.h"

namespace tessera {
namespace {

using nlohmann::json;

/// With its later lines below the first one's text.
std::string row(const std::string& name, std::string text) {
  constexpr int kWidth = 11;
  for (size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', end + 1))
    text.insert(end + 1, kWidth, ' ');
  return fmt::format("{:<{}}{}\n", name, kWidth, text);
}

/// Whether the stage runs in every build and for all options.
bool is_needed(const std::string& stage) {
  return stage == "ingest" || stage == "train" || stage == "evaluate";
}

/// "4:32 (ingest 20.1 s, train 4:01, …)", of the stages that ran.
std::string time_text(const json& result) {
  std::string stages;
  bool all = true;
  for (const char* stage : {"ingest", "train", "evaluate", "export", "page", "report"}) {
    const auto seconds = result["stage_seconds"].find(stage);
    if (seconds == result["stage_seconds"].end()) {
      all = all && !is_needed(stage);
      continue;
    }
    stages += fmt::format("{}{} {}", stages.empty() ? "" : ", ", stage,
                          duration_text(seconds->get<double>()));
  }
  if (stages.empty()) return "all stages were done before";
  return fmt::format("{} ({}{})", duration_text(result["total_seconds"]), stages,
                     all ? "" : "; the other stages were done before");
}

std::string gaussians_text(const json& result) {
  return fmt::format("{} ({} static + {} dynamic)", result["num_gaussians"].get<int64_t>(),
                     result["num_static"].get<int64_t>(), result["num_dynamic"].get<int64_t>());
}

bool has_player(const json& result) {
  return result.contains("player");
}

std::string sizes_text(const json& result) {
  std::string text = "model " + size_text(result["training"]["bytes"]);
  if (has_player(result)) text += ", player page " + size_text(result["player"]["bytes"]);
  return text;
}

std::string places_text(const json& result) {
  std::string text;
  const auto add = [&](const char* name, const std::string& place) {
    text += fmt::format("  {:<15} {}\n", name, place);
  };
  if (has_player(result))
    add("player page",
        fmt::format("{}/{}", result["player"]["folder"].get<std::string>(), kPageFile));
  if (result.contains("report")) add("report", result["report"]);
  add("model", result["model"]);
  add("scores", result["metrics"]);
  add("prepared scene", result["scene"]);
  const json& exported = result["export"];
  if (exported["frames"] > 0)
    add("PLY frames", fmt::format("{} ({} files, {})", exported["folder"].get<std::string>(),
                                  exported["frames"].get<int64_t>(), size_text(exported["bytes"])));
  return text;
}

/// One page opens by itself; a folder that was too large for that needs a server.
std::string player_advice(const json& result) {
  const json& player = result["player"];
  const std::string view = shell_line({"tessera", "view", result["out"].get<std::string>()});
  if (player["format"] != "html")
    return fmt::format("  Show the player in a web browser:\n    {}\n", view);
  return fmt::format("  Open {}/{} in a web browser; from another machine, by a server:\n    {}\n",
                     player["folder"].get<std::string>(), kPageFile, view);
}

std::string next_text(const json& result) {
  const std::string out = result["out"], path = result["camera_path"];
  return (has_player(result) ? player_advice(result) : "") +
         fmt::format("  Render a video along a camera path (orbit or spiral):\n    {}\n",
                     shell_line({"tessera", "render", out, "--path", path, "--mp4", "-o",
                                 out + "/" + path + ".mp4"})) +
         fmt::format(
             "  Export the model for another program (formats: tessera export --help):\n"
             "    {}",
             shell_line({"tessera", "export", out, "--format", "ply", "-o", out + "/ply"}));
}

}  // namespace

std::string run_summary(const json& result, ScoreDetail detail) {
  const std::string scores = scores_text(result, detail);
  return row("Quality", scores.empty() ? "no test views" : scores) +
         row("Gaussians", gaussians_text(result["training"])) + row("Time", time_text(result)) +
         row("Sizes", sizes_text(result)) + "\nResults\n" + places_text(result) + "\nNext\n" +
         next_text(result);
}

}  // namespace tessera
