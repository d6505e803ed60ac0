// The program `colmap`: finds it, checks its version and runs its commands, with their output in a
// log.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ingest/ingest.h"

namespace tessera {

/// Options of a command in order: {"--image_path", "…"}.
using ColmapOptions = std::vector<std::pair<std::string, std::string>>;

/// A command that ended with an error.
class ColmapFailure : public InputError {
 public:
  ColmapFailure(const std::string& message, std::string seen, std::filesystem::path log_file)
      : InputError(message), reason(std::move(seen)), log(std::move(log_file)) {}

  /// Whether COLMAP ended because the images show no point that two of them see.
  bool has_no_common_points() const;
  /// The failure where it is another one; else one that says so in a sentence: `images` are named,
  /// `remedy` is what to do, and the log's path is at the end.
  [[noreturn]] void rethrow(const std::vector<std::string>& images,
                            const std::string& remedy) const;

  std::string reason;         // the check that failed, else the last words
  std::filesystem::path log;  // of all that it printed
};

/// What `make` returns; nothing where COLMAP finds no common points.
template <class Make>
auto with_points(const Make& make) -> std::optional<decltype(make())> {
  try {
    return make();
  } catch (const ColmapFailure& failure) {
    if (!failure.has_no_common_points()) throw;
    return std::nullopt;
  }
}

class ColmapProgram {
 public:
  /// The program that the environment variable TESSERA_COLMAP names, else `colmap` of PATH; what
  /// its commands print is added to `log`. Errors: InputError: there is none, it states no version,
  /// or one before 3.6.
  ColmapProgram(std::filesystem::path log, const IngestProgress& progress);

  const std::string& version() const { return version_; }  // "3.8"
  const std::filesystem::path& log() const { return log_; }

  /// Runs it to its end. `doing` and `total` (0: what the lines state, else not known) are for
  /// progress; one step is done with each line that contains `step`. Errors: ColmapFailure with its
  /// last words and the log's path; what `progress` throws, after the program and its children are
  /// gone.
  void run(const std::string& command, const ColmapOptions& options, const std::string& doing,
           const std::string& step = "", int64_t total = 0,
           const std::string& remedy = "put that right, or pass --poses FILE") const;

  // Commands whose options are named differently in the versions; without a graphics card.
  void extract_features(ColmapOptions options, int64_t images) const;
  /// `matcher`: "exhaustive_matcher" or "sequential_matcher".
  void match_features(const std::string& matcher, ColmapOptions options) const;

 private:
  /// 3.12 renamed what holds for all kinds of features.
  bool has_feature_groups() const { return major_ > 3 || (major_ == 3 && minor_ >= 12); }

  /// Takes the version from a line that states it: "COLMAP 3.8 -- Structure-from-Motion".
  void read_version(std::string_view line);

  std::filesystem::path program_, log_;
  const IngestProgress& progress_;
  std::string version_;
  int major_ = 0, minor_ = 0;
};

}  // namespace tessera
