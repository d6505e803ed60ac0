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

/// `scene` of the run folder `run`, which was moved with it: the scene in the OUT of `tessera run`,
/// of its run, of the windows of a clip in that run, or of the static set of these. "" where none
/// lies there.
std::string moved_scene(const std::filesystem::path& run, const std::filesystem::path& scene);

/// The scene that a model was trained on: `model` is a run folder, an OUT of `tessera run`, or lies
/// in a run folder. Of the scene that config.json names, the scene in OUT (which was moved with the
/// run) and `others` the first that is as it was trained on, else the first that is there; "" where
/// none is.
std::string scene_of_model(const std::filesystem::path& model,
                           const std::vector<std::filesystem::path>& others = {});

/// A line where `scene`, which is not "", is not as that model was trained on: it may hold out
/// other cameras. "" else.
std::string changed_scene(const std::filesystem::path& model, const std::string& scene);

/// The core of the window that such a model was trained on, where `scene` is its scene, by place or
/// by content.
std::optional<Window> core_of_model(const std::filesystem::path& model,
                                    const std::filesystem::path& scene);

}  // namespace tessera
