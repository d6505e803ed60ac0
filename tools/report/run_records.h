// The files that a training has left, as a report needs them: of one clip, or of one that was
// trained window by window.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera {

/// One window of a long clip.
struct WindowRecords {
  std::string folder;         // relative to that of the clip: "windows/0000"
  double begin = 0, end = 0;  // of what is drawn of it, normalised time of the clip
  std::string log;
};

/// The files of a run; null or empty where there is none.
struct RunRecords {
  nlohmann::json config, metrics;  // RUN/config.json, RUN/metrics.json
  nlohmann::json stages;           // OUT/stages.json of `tessera run`
  std::string log;                 // RUN/log.jsonl; of a clip in windows that of the first
  nlohmann::json trained{};        // what `tessera train --json` printed, for a run without a log
  std::vector<WindowRecords> windows{};  // of a clip in windows
  std::string static_log{};              // of the training of what stands still in it
  double seconds = 0;                    // of such a clip
};

/// Null where the file is missing or damaged: a report contains what is there.
nlohmann::json json_if_sound(const std::filesystem::path& file);

/// What a training has written into a run folder or the folder of a clip in windows, whose options
/// are those of its first window: config, metrics, log and windows.
RunRecords read_records(const std::filesystem::path& run);

}  // namespace tessera
