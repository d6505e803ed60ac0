// What: the files of a run folder and what its config.json says.
// Not: training.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>

namespace tessera {

struct RunFolder {
  std::filesystem::path root;

  std::filesystem::path config() const { return root / "config.json"; }
  std::filesystem::path log() const { return root / "log.jsonl"; }
  std::filesystem::path checkpoint() const { return root / "checkpoint.ckpt"; }
  std::filesystem::path model() const { return root / "model.ply"; }
  std::filesystem::path metrics() const { return root / "metrics.json"; }

  /// Whether a training has written here.
  bool exists() const { return std::filesystem::exists(config()); }
  /// Errors: InputError when it is missing or damaged.
  nlohmann::json read_config() const;
  /// Removes the files above and nothing else.
  void remove_files() const;
};

}  // namespace tessera
