// The bytes of the exported file that `info --shipped` and `evaluate --json` state.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Bugs put back: encoded without the cameras of the run's scene; stated where it was not asked for;
// each seen to fail.
TEST(CliShipped, InfoAndEvaluateStateTheSizeOfTheExportedFile) {
  TESSERA_SKIP_WITHOUT_INGEST();
  const CliWorkspace work;
  work.film_object("film", 3, 24);
  ASSERT_EQ(work.run({"ingest", work.at("film"), "-o", work.at("scene")}).exit_code, 0);
  ASSERT_EQ(work.run({"train", work.at("scene"), "-o", work.at("run"), "--preset", "fast",
                      "--iterations", "20", "--init-points", "300", "--backend", "cpu"})
                .exit_code,
            0);
  ASSERT_EQ(work.run({"export", work.at("run"), "-o", work.at("single"), "--format", "tessera",
                      "--single"})
                .exit_code,
            0);
  const auto bytes = fs::file_size(work / "single/scene.t4d");
  EXPECT_EQ(work.run_json({"info", work.at("run"), "--shipped"})["shipped_bytes"], bytes);
  EXPECT_EQ(work.run_json({"info", work.at("single/scene.t4d")})["bytes"], bytes);
  EXPECT_EQ(work.run_json({"evaluate", work.at("run")})["shipped_bytes"], bytes);
  EXPECT_FALSE(work.run_json({"info", work.at("run")}).contains("shipped_bytes"));
  work.expect_refused({"info", work.at("scene"), "--shipped"},
                      {"is no model but a prepared scene", "--shipped"});
}

}  // namespace
}  // namespace tessera::testing
