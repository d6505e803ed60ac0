// The training options of the command line, shared by `train` and `run`.
// recon4d/options/train_options.h documents their meaning.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ingest/clocks/windows.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"
#include "tools/cli/command.h"
#include "tools/session/clock/session_events.h"

namespace tessera {

constexpr const char* kNever = "never";  // as --evaluate-every has kNeverEvaluate

struct TrainArguments {
  std::string preset = "balanced", ablation, config, backend = "auto";
  std::map<std::string, std::string> given;  // option key → text, as typed
  int threads = 0;
  int64_t evaluate_every = 0;  // of EvaluationPlan
  std::optional<int64_t> checkpoint_every;
};

/// One option per row of the option table, and --preset, --ablation, --config, --backend,
/// --threads, ….
void add_train_options(CLI::App& command, TrainArguments& arguments);
/// Of these the option table alone, and --static.
void add_option_table(CLI::App& command, TrainArguments& arguments);
/// The words that say the same, without those of device and threads.
std::vector<std::string> words_of(const TrainArguments& arguments);
/// Defaults ← preset ← ablation ← --config ← command line; presets look at the scene. Errors:
/// InputError.
PlannedOptions resolve_options(const TrainArguments& arguments, SceneFacts facts);
/// The same for the scene in that folder, whose cameras and times are read. Errors: as load_scene.
PlannedOptions resolve_options(const TrainArguments& arguments, const std::filesystem::path& scene,
                               const std::optional<Window>& window = {});

}  // namespace tessera
