// Reads the headers of checkpoints and the ends of logs, and the command line that Linux keeps of a
// process.
#include "tools/live/stopped_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "recon4d/model/checkpoint.h"
#include "tools/cli/background_program.h"
#include "tools/export/player_files.h"
#include "tools/report/log_events.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Whether the last session of a training has found it finished at `step`, as by patience.
bool has_ended_at(const RunFolder& run, int64_t step) {
  const nlohmann::json result = last_result(run);
  return result.is_object() && result.value("finished", false) &&
         result.value("iterations", int64_t{-1}) == step;
}

std::string resume_advice(const fs::path& path, const RunFolder& run) {
  if (is_run_output(path))
    return fmt::format("repeat the `tessera run` command of {} to resume", path.string());
  return "resume with: " + shell_line(resume_words(run));
}

}  // namespace

nlohmann::json last_result(const RunFolder& run) {
  std::ifstream file(run.log());
  const std::string log{std::istreambuf_iterator<char>(file), {}};
  const std::vector<nlohmann::json> events = log_events(log);
  const bool has_ended = !events.empty() && text_at(events.back(), "event") == "end";
  return has_ended ? events.back() : nlohmann::json();
}

std::optional<StoppedTraining> stopped_training(const RunFolder& run) {
  std::error_code absent;
  if (!fs::is_regular_file(run.checkpoint(), absent)) return std::nullopt;
  try {
    const nlohmann::json header = read_checkpoint_header(run.checkpoint());
    const StoppedTraining stopped{header.at("iteration").get<int64_t>(),
                                  header.at("options").at("iterations").get<int64_t>()};
    const bool is_finished = header.at("finished").get<bool>() || has_ended_at(run, stopped.step);
    return is_finished ? std::nullopt : std::optional(stopped);
  } catch (const std::exception&) {  // whoever resumes it is told what is wrong
    return std::nullopt;
  }
}

bool is_complete(const RunFolder& run) {
  std::error_code absent;
  return fs::is_regular_file(run.model(), absent) && !stopped_training(run);
}

bool has_player_of(const RunFolder& run, const fs::path& out) {
  std::error_code no_player, no_model;
  const auto written = fs::last_write_time(out / "player" / kPageFile, no_player);
  const auto trained = fs::last_write_time(run.model(), no_model);
  return !no_player && !no_model && written >= trained;
}

std::vector<std::string> resume_words(const RunFolder& run) {
  return {"tessera", "train", run.scene(), "-o", run.root.string(), "--resume"};
}

std::string stopped_line(const fs::path& path) {
  const RunFolder run{run_folder_of(path)};
  if (const auto stopped = stopped_training(run))
    return fmt::format("stopped after {} of {} steps; {}", stopped->step, stopped->total,
                       resume_advice(path, run));
  return "";
}

std::string repeated_command() {
  std::ifstream file("/proc/self/cmdline");
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');)
    if (!word.starts_with("--view")) words.push_back(word);
  return shell_line(words);
}

}  // namespace tessera
