// The files of a run folder, and the contents of its config.json.
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ingest/clocks/windows.h"

namespace tessera {

struct RunFolder {
  std::filesystem::path root;

  std::filesystem::path config() const { return root / "config.json"; }
  std::filesystem::path log() const { return root / "log.jsonl"; }
  std::filesystem::path checkpoint() const { return root / "checkpoint.ckpt"; }
  std::filesystem::path model() const { return root / "model.ply"; }
  /// Gains of the training images, where they were learnt.
  std::filesystem::path exposure() const { return root / "exposure.json"; }
  std::filesystem::path metrics() const { return root / "metrics.json"; }
  /// The best model by validation, of that step.
  std::filesystem::path best(int64_t iteration) const;

  /// Whether a training has written here.
  bool exists() const { return std::filesystem::exists(config()); }
  /// For a new training; one that ended before its first checkpoint has left nothing to lose.
  /// Errors: InputError: a run is here, or a file that no training has written, by its name.
  void require_room() const;
  /// Errors: InputError when it is missing or damaged.
  nlohmann::json read_config() const;
  /// The scene that was trained on; "" where no training has written here.
  std::string scene() const;
  /// The part of the scene that was trained on; nothing: all of it.
  std::optional<Window> window() const;
  /// The run whose static set a training has left as it was; "" where it has trained its own.
  std::string static_model() const;
  /// What `made_for` of the training's request was (train_session.h); "" where no training has
  /// written here, or its config.json is damaged.
  std::string made_for() const;
  /// Removes the files above, config.json first, and nothing else.
  void remove_files() const;
  /// Removes best models of other steps.
  void remove_best_but(int64_t iteration) const;
};

/// The run folder that `path` means: the one inside where `path` is an OUT of `tessera run`, else
/// `path` as it is.
std::filesystem::path run_folder_of(const std::filesystem::path& path);

}  // namespace tessera
