// What a request does where a folder holds an earlier one.
#include "tools/cli/run_record.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using nlohmann::json;
using Changes = std::vector<std::string>;

const json kFast = {{"preset", "fast"},
                    {"contents of the capture", "a1"},
                    {"options", {{"iterations", 30}, {"lr_mean", 1e-4}, {"sweep", true}}}};

json with(json request, const json::json_pointer& key, const json& value) {
  request[key] = value;
  return request;
}

// Bugs put back, each seen to fail: options of another preset listed one by one; an option that an
// older version does not have taken for a change.
TEST(RunRecord, ChangesAreNamed) {
  EXPECT_EQ(changes(kFast, kFast), Changes{});
  EXPECT_EQ(changes(kFast, with(kFast, "/options/iterations"_json_pointer, 60)),
            Changes{"iterations 30 → 60"});
  EXPECT_EQ(changes(kFast, with(kFast, "/options/new_option"_json_pointer, 1)), Changes{});
  EXPECT_EQ(changes(with(kFast, "/options/old_option"_json_pointer, 1), kFast), Changes{});
  json best = with(kFast, "/preset"_json_pointer, "best");
  best["options"]["iterations"] = 7000;
  EXPECT_EQ(changes(kFast, best), Changes{"preset fast → best"});
  EXPECT_EQ(changes(kFast, with(kFast, "/contents of the capture"_json_pointer, "b2")),
            Changes{"the contents of the capture"});
  EXPECT_EQ(changes(json::parse(kFast.dump()), kFast), Changes{}) << "as it is read from a file";
  EXPECT_EQ(changes({{"held_out", json::array({"cam00"})}}, {{"held_out", {"cam03"}}}),
            Changes{R"(held_out ["cam00"] → ["cam03"])"});
  EXPECT_EQ(text_of_changes({"a", "b"}), "a, b");
  EXPECT_EQ(text_of_changes({"a", "b", "c", "d", "e", "f"}), "a, b, c, d and 2 more");
}

struct Case {
  const char* what;
  bool checkpoint, model, finished, known, same, overwrite;
  RunAction action;
};

// Bugs put back, each seen to fail: what is of another request replaced where --overwrite is left
// out; a finished run of the same request trained again with --overwrite; a run of an unknown
// request resumed; an unfinished run of another request started anew.
TEST(RunRecord, NothingIsReplacedUnasked) {
  const json other = with(kFast, "/options/iterations"_json_pointer, 60);
  for (const Case& c : {
           Case{"nothing is there", false, false, false, true, true, false, RunAction::kStart},
           Case{"only begun", false, false, false, true, false, false, RunAction::kStart},
           Case{"stopped", true, true, false, true, true, false, RunAction::kResume},
           Case{"stopped, --overwrite", true, true, false, true, true, true, RunAction::kResume},
           Case{"its checkpoint is lost", false, true, false, true, true, false,
                RunAction::kRefuse},
           Case{"stopped, other options", true, true, false, true, false, false,
                RunAction::kRefuse},
           Case{"stopped, not known", true, true, false, false, false, false, RunAction::kRefuse},
           Case{"stopped, other, --overwrite", true, true, false, true, false, true,
                RunAction::kReplace},
           Case{"finished", true, true, true, true, true, false, RunAction::kDone},
           Case{"finished, --overwrite", true, true, true, true, true, true, RunAction::kDone},
           Case{"finished without checkpoint", false, true, true, true, true, false,
                RunAction::kDone},
           Case{"finished, other options", true, true, true, true, false, false,
                RunAction::kRefuse},
           Case{"finished, not known", true, true, true, false, false, false, RunAction::kRefuse},
           Case{"finished, other, --overwrite", true, true, true, true, false, true,
                RunAction::kReplace},
           Case{"not known, --overwrite", true, true, true, false, false, true,
                RunAction::kReplace},
       }) {
    const RunRecord record{c.checkpoint, c.model, c.finished,
                           !c.known ? json()
                           : c.same ? kFast
                                    : other};
    EXPECT_EQ(plan_run(record, kFast, c.overwrite).action, c.action) << c.what;
  }
}

// Bug put back: "a finished run" of one that has stopped; seen to fail.
TEST(RunRecord, ARefusalNamesWhatDiffersAndWhatIsKept) {
  const auto text = [](const RunRecord& record, const std::vector<std::string>& changed) {
    return std::string(refused_run("results/dance/", record, {RunAction::kRefuse, changed}).what());
  };
  EXPECT_EQ(text({true, true, true, kFast}, {"seed 1 → 5"}),
            "results/dance/: holds a finished run; changed: seed 1 → 5; take another -o, or pass "
            "--overwrite, which keeps this one as dance.1");
  EXPECT_NE(text({true, false, false, kFast}, {"seed 1 → 5"}).find("an unfinished run; changed"),
            std::string::npos);
  EXPECT_NE(text({true, true, true, {}}, {}).find("is not known"), std::string::npos);
  EXPECT_NE(text({false, true, false, kFast}, {}).find("lost its checkpoint"), std::string::npos);
}

}  // namespace
}  // namespace tessera
