// Records which stages of a `tessera run` are done, and for which inputs and options (stages.json).
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace tessera {

class StageLedger {
 public:
  /// Reads the ledger if there is one. Errors: InputError when it is damaged.
  explicit StageLedger(std::filesystem::path file);

  /// Whether the stage was finished with this key.
  bool done(const std::string& stage, const std::string& key) const;
  /// Whether it was begun with whatever key.
  bool knows(const std::string& stage) const { return entries_.contains(stage); }
  void begin(const std::string& stage, const std::string& key);
  /// `seconds`: what the stage took, where that is to be kept.
  void finish(const std::string& stage, const std::string& key, const nlohmann::json& result,
              std::optional<double> seconds = {});
  /// What the finished stage returned.
  const nlohmann::json& result(const std::string& stage) const;

 private:
  void set(const std::string& stage, nlohmann::json entry);

  std::filesystem::path file_;
  nlohmann::json entries_ = nlohmann::json::object();
};

/// 64-bit FNV-1a in hex: keys are hashes of everything that a stage depends on.
std::string key_of(const nlohmann::json& inputs);

/// Names, sizes and modification times of every file below a folder (or of a file).
nlohmann::json file_stamps(const std::filesystem::path& path);

}  // namespace tessera
