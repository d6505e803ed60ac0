// How a training that runs no more has ended: complete, or where it has stopped and how it is
// resumed.
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/session/run_folder.h"

namespace tessera {

/// What the last session of a training printed at its end, with `event`; null where it has not come
/// to an end.
nlohmann::json last_result(const RunFolder& run);

struct StoppedTraining {
  int64_t step = 0, total = 0;
};

/// By the checkpoint of `run`, which no training writes now. None where it has none, the training
/// is finished, or the checkpoint is damaged.
std::optional<StoppedTraining> stopped_training(const RunFolder& run);

/// Whether `run`, which no training writes now, holds the model of a training that is finished.
bool is_complete(const RunFolder& run);

/// Whether `out` has a player, and of the model that `run` holds: it was written after it.
bool has_player_of(const RunFolder& run, const std::filesystem::path& out);

/// `tessera train SCENE -o RUN --resume`. Errors: InputError: the run's config.json is damaged.
std::vector<std::string> resume_words(const RunFolder& run);

/// "stopped after 429 of 4000 steps; resume with: tessera train …" of an OUT of `tessera run` or a
/// run folder; "" where no training has stopped there.
std::string stopped_line(const std::filesystem::path& path);

/// The command line of this process without --view, as it would be typed into a shell.
std::string repeated_command();

}  // namespace tessera
