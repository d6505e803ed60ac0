// What a training or a run was asked for, how two requests differ, and what a new request does
// where a folder holds an earlier one: nothing that is there is ever lost.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "kernels/base/errors.h"

namespace tessera {

/// The values by which two requests differ, as in "preset fast → balanced" and "iterations 30 →
/// 60". Requests are objects; those in them are compared by their values. A value that one request
/// alone has does not count: another version of the program has more options. Where the preset
/// differs, the options that follow from it are not listed.
std::vector<std::string> changes(const nlohmann::json& before, const nlohmann::json& now);

/// The first four, and how many more there are.
std::string text_of_changes(const std::vector<std::string>& changes);

/// What a folder holds of a training, or of the trainings of a clip in windows.
struct RunRecord {
  bool has_checkpoint = false, has_model = false;  // of any of them
  bool finished = false;                           // the last step is taken
  nlohmann::json request;  // that it was begun with; null where it is not known
};

enum class RunAction {
  kStart,    // from the first step: nothing is there
  kResume,   // from what is there
  kDone,     // nothing is left to do
  kRefuse,   // what is there is of another request
  kReplace,  // the same, and the caller makes room: RunLock::make_room
};

struct RunPlan {
  RunAction action = RunAction::kStart;
  std::vector<std::string> changed;  // from the request of the folder
};

/// Pure: decides on hours of work. What is of the request is resumed or done; what is of another
/// one is never lost: it is refused, or with `overwrite` replaced.
RunPlan plan_run(const RunRecord& record, const nlohmann::json& request, bool overwrite);

/// "OUT: holds a finished run; changed: iterations 30 → 60; take another -o, …" of a plan that
/// refuses.
InputError refused_run(const std::filesystem::path& out, const RunRecord& record,
                       const RunPlan& plan);

/// plan_run of the folder `out`, whose refusal is an error. Errors: InputError: refused_run.
RunAction action_in(const std::filesystem::path& out, const RunRecord& record,
                    const nlohmann::json& request, bool overwrite);

}  // namespace tessera
