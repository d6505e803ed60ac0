// One stage of `tessera run`: it is done again only where what it is made of has changed, or what
// it made is gone or is another's.
#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/cli/stage_ledger.h"

namespace tessera {

struct RunStage {
  int number;
  const char *name, *entry;  // in messages; in stages.json
  bool owns_product = true;  // false: the product may be edited by hand, as a prepared scene
  bool has_lines = false;    // says more than its end: its beginning is said, too

  /// `text` after "[2/6] train".
  std::string message(const std::string& text) const;
};

class RunStages {
 public:
  /// `file`: stages.json. Errors: as StageLedger.
  explicit RunStages(std::filesystem::path file) : ledger_(std::move(file)) {}

  /// Does the stage unless it was done for these inputs and `product` is still there. `make`
  /// returns its result, nothing where it was stopped before its end. False when interrupted.
  bool done(const RunStage& stage, const nlohmann::json& inputs,
            const std::filesystem::path& product,
            const std::function<std::optional<nlohmann::json>()>& make);
  /// Whether `product` is what the stage has made, as far as that is told.
  bool is_as_written(const RunStage& stage, const std::filesystem::path& product) const;

  StageLedger& ledger() { return ledger_; }
  const StageLedger& ledger() const { return ledger_; }
  /// By the names of the stages that ran.
  const std::map<std::string, double>& seconds() const { return seconds_; }

 private:
  std::string why_again(const RunStage& stage, const nlohmann::json& inputs, bool is_there,
                        const std::filesystem::path& product) const;

  StageLedger ledger_;
  std::map<std::string, double> seconds_;
};

}  // namespace tessera
