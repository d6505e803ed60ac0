// What a training or a run was asked for, how two requests differ, and what a new request does
// where a folder holds an earlier one: nothing that is finished is replaced, unless that is asked
// for.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera {

/// The values by which two requests differ, as in "preset fast → balanced" and "iterations 30 →
/// 60". Requests are objects; those in them are compared by their values. A value that one request
/// alone has does not count: another version of the program has more options. Where the preset
/// differs, the options that follow from it are not listed.
std::vector<std::string> changes(const nlohmann::json& before, const nlohmann::json& now);

/// The first four, and how many more there are.
std::string text_of_changes(const std::vector<std::string>& changes);

/// What a folder holds.
struct RunRecord {
  bool has_checkpoint = false, has_model = false;
  bool finished = false;   // the training has taken its last step
  nlohmann::json request;  // that it was begun with; null where it is not known
};

enum class RunAction {
  kStart,    // from the first step
  kResume,   // from the checkpoint
  kReplace,  // from the first step, in place of a finished run
  kDone,     // nothing is left to do
  kRefuse    // a finished run would be lost
};

struct RunPlan {
  RunAction action = RunAction::kStart;
  std::vector<std::string> changed;  // from the request of the folder
};

/// Pure: decides on hours of work. An unfinished run of another request starts anew, and its
/// checkpoint is the caller's to rename; a finished one is refused without `overwrite`.
RunPlan plan_run(const RunRecord& record, const nlohmann::json& request, bool overwrite);

}  // namespace tessera
