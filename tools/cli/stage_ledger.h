// Records which stages of a `tessera run` are done, and for which inputs and options (stages.json).
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

class StageLedger {
 public:
  /// Reads the ledger if there is one. Errors: InputError when it is damaged.
  explicit StageLedger(std::filesystem::path file);

  /// Whether the stage was finished with inputs of these values (changes() of run_record.h).
  bool done(const std::string& stage, const nlohmann::json& inputs) const;
  /// By which values these inputs differ from those that the stage was begun with; none where it
  /// was not, or by a version that did not record them.
  std::vector<std::string> changed(const std::string& stage, const nlohmann::json& inputs) const;
  /// The inputs of a stage; null where they are not known.
  nlohmann::json inputs(const std::string& stage) const;
  void begin(const std::string& stage, const nlohmann::json& inputs);
  /// `seconds`: what the stage took, where that is to be kept. `product`: file_stamps of what it
  /// wrote.
  void finish(const std::string& stage, const nlohmann::json& result,
              std::optional<double> seconds = {}, const nlohmann::json& product = {});
  /// Whether what a finished stage wrote has these stamps; where they are not known, it has.
  bool wrote(const std::string& stage, const nlohmann::json& product) const;
  /// The entry of a stage becomes that of another ledger.
  void adopt(const std::string& stage, const StageLedger& other);
  bool is_finished(const std::string& stage) const;
  /// When the stage was finished: another text each time; "" where it was not.
  std::string finished_at(const std::string& stage) const;
  /// What the finished stage returned.
  const nlohmann::json& result(const std::string& stage) const;

 private:
  void set(const std::string& stage, nlohmann::json entry);

  std::filesystem::path file_;
  nlohmann::json entries_ = nlohmann::json::object();
};

/// 64-bit FNV-1a in hex.
std::string key_of(const nlohmann::json& inputs);

/// What identifies every file below a folder (or a file), but for where the folder lies and when it
/// was written: its name, its size, and a hash of its contents: of text whole, as one digit of a
/// calibration matters; of images, videos and models of ten blocks.
nlohmann::json file_stamps(const std::filesystem::path& path);

}  // namespace tessera
