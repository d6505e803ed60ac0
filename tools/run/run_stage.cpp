// Products are told apart by size and ends of their files.
#include "tools/run/run_stage.h"

#include <fmt/format.h>

#include <chrono>
#include <vector>

#include "kernels/base/seconds_since.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/run_record.h"
#include "tools/cli/terminal.h"

namespace tessera {

using nlohmann::json;

std::string RunStage::message(const std::string& text) const {
  return fmt::format("[{}/6] {}{}", number, name, text);
}

bool RunStages::done(const RunStage& stage, const json& inputs,
                     const std::filesystem::path& product,
                     const std::function<std::optional<json>()>& make) {
  const bool is_there = std::filesystem::exists(product);
  if (ledger_.done(stage.entry, inputs) && is_there && is_as_written(stage, product)) {
    say(stage.message(": done before, unchanged"));
    return true;
  }
  if (const std::string why = why_again(stage, inputs, is_there, product);
      stage.has_lines || !why.empty())
    say(stage.message(why));
  const auto begin = std::chrono::steady_clock::now();
  ledger_.begin(stage.entry, inputs);
  const std::optional<json> result = make();
  if (!result) return false;
  seconds_[stage.name] = seconds_since(begin);
  ledger_.finish(stage.entry, *result, seconds_[stage.name],
                 stage.owns_product ? file_stamps(product) : json());
  say(stage.message(fmt::format(": done in {}", duration_text(seconds_[stage.name]))));
  return !interrupted();
}

bool RunStages::is_as_written(const RunStage& stage, const std::filesystem::path& product) const {
  return !stage.owns_product || ledger_.wrote(stage.entry, file_stamps(product));
}

std::string RunStages::why_again(const RunStage& stage, const json& inputs, bool is_there,
                                 const std::filesystem::path& product) const {
  if (!ledger_.is_finished(stage.entry)) return "";
  if (!is_there) return fmt::format(" again: {} is gone", product.string());
  if (!is_as_written(stage, product))
    return fmt::format(" again: {} is not what this run has written", product.string());
  const std::vector<std::string> changed = ledger_.changed(stage.entry, inputs);
  return changed.empty() ? " again: what it was made of is not known"
                         : " again: changed: " + text_of_changes(changed);
}

}  // namespace tessera
