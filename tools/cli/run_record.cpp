// Comparison of requests value by value, and the decision on a folder.
#include "tools/cli/run_record.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tessera {
namespace {

using nlohmann::json;

constexpr const char* kPreset = "preset";
constexpr const char* kOptions = "options";

std::string value_text(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.is_null() ? "none" : value.dump();
}

void add_changes(const json& before, const json& now, const std::string& name,
                 std::vector<std::string>& found) {
  if (before.is_object() && now.is_object()) {
    const bool other_preset =
        before.contains(kPreset) && now.contains(kPreset) && before[kPreset] != now[kPreset];
    for (const auto& [key, value] : now.items())
      if (before.contains(key) && !(other_preset && key == kOptions))
        add_changes(before[key], value, key, found);
    return;
  }
  if (before == now) return;  // 30 and 30.0 are equal
  const bool is_hash = name.starts_with("contents of ");
  found.push_back(is_hash ? "the " + name
                          : fmt::format("{} {} → {}", name, value_text(before), value_text(now)));
}

}  // namespace

std::vector<std::string> changes(const json& before, const json& now) {
  std::vector<std::string> found;
  add_changes(before, now, "", found);
  return found;
}

std::string text_of_changes(const std::vector<std::string>& changes) {
  constexpr size_t kNamed = 4;
  const size_t named = std::min(changes.size(), kNamed);
  std::string text =
      fmt::format("{}", fmt::join(changes.begin(), changes.begin() + std::ptrdiff_t(named), ", "));
  if (changes.size() > named) text += fmt::format(" and {} more", changes.size() - named);
  return text;
}

RunPlan plan_run(const RunRecord& record, const json& request, bool overwrite) {
  RunPlan plan;
  if (!record.has_checkpoint && !record.has_model) return plan;
  const bool known = record.request.is_object();
  if (known) plan.changed = changes(record.request, request);
  const bool is_same = known && plan.changed.empty();
  if (is_same && record.finished)
    plan.action = RunAction::kDone;
  else if (is_same && record.has_checkpoint)
    plan.action = RunAction::kResume;
  else
    plan.action = overwrite ? RunAction::kReplace : RunAction::kRefuse;
  return plan;
}

InputError refused_run(const std::filesystem::path& out, const RunRecord& record,
                       const RunPlan& plan) {
  const std::string why = !plan.changed.empty()        ? "changed: " + text_of_changes(plan.changed)
                          : record.request.is_object() ? "it has lost its checkpoint"
                                                       : "what it was asked for is not known";
  return InputError(fmt::format(
      "{}: holds {} run; {}; take another -o, or pass --overwrite, which keeps this one as {}.1",
      out.string(), record.finished ? "a finished" : "an unfinished", why,
      (out / "").parent_path().filename().string()));
}

RunAction action_in(const std::filesystem::path& out, const RunRecord& record, const json& request,
                    bool overwrite) {
  const RunPlan plan = plan_run(record, request, overwrite);
  if (plan.action == RunAction::kRefuse) throw refused_run(out, record, plan);
  return plan.action;
}

}  // namespace tessera
