// Results of runs as points and CSV.
#include "tools/batch/points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

json run(const char* label, int64_t iterations, int64_t seed, double psnr, double seconds) {
  return {{"scene", "lego"},
          {"split", "val"},
          {"label", label},
          {"iterations", iterations},
          {"seed", seed},
          {"status", "done"},
          {"device", "cpu, 2 threads"},
          {"metrics", {{"psnr", psnr}, {"seconds", seconds}, {"bytes", 3 << 20}}}};
}

/// Three seeds of one point, one of them failed; two more points.
json some_cells() {
  json runs = {run("fast", 100, 1, 20, 2), run("fast", 100, 2, 22, 4), run("fast", 100, 3, 99, 9),
               run("fast", 900, 1, 25, 20), run("best", 900, 1, 25.5, 200)};
  runs[2]["status"] = "failed";
  runs[2]["error"] = "step 7: loss is not finite, \"mean\"";
  runs[2].erase("metrics");
  return runs;
}

// Bug put back: the upper of the middle two for an even number; seen to fail.
TEST(PointSpread, MedianLeastAndMost) {
  const Spread odd = spread_of({3, 1, 10}).value();
  EXPECT_EQ(odd.median, 3);
  EXPECT_EQ(odd.least, 1);
  EXPECT_EQ(odd.most, 10);
  EXPECT_EQ(odd.count, 3);
  EXPECT_EQ(spread_of({4, 1, 2, 10})->median, 3);
  EXPECT_EQ(spread_of({7})->median, 7);
}

// Bug put back: what is not finite counts; seen to fail.
TEST(PointSpread, WhatIsNotFiniteDoesNotCount) {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(spread_of({nan, 2, infinite})->count, 1);
  EXPECT_FALSE(spread_of({nan}));
  EXPECT_FALSE(spread_of({}));
}

// Bug put back: failed runs counted in n; seen to fail.
TEST(Points, PointsAreMediansOverSeeds) {
  const json scenes = points_of(some_cells());
  ASSERT_EQ(scenes.size(), 1u);
  ASSERT_EQ(scenes[0]["points"].size(), 3u);
  const json& point = scenes[0]["points"][0];
  EXPECT_EQ(point["n"], 2);
  EXPECT_EQ(point["metrics"]["psnr"]["median"], 21);
  EXPECT_EQ(point["metrics"]["seconds"]["least"], 2);
  EXPECT_EQ(point["metrics"]["seconds"]["most"], 4);
  EXPECT_FALSE(point["metrics"].contains("ssim")) << "not measured";
  EXPECT_EQ(point["errors"], json::array({"step 7: loss is not finite, \"mean\""}));
}

// Bug put back: quotes of a field not doubled; seen to fail.
TEST(Points, CsvHasALineAPoint) {
  json runs = some_cells();
  runs[3]["device"] = "a \"big\", fast card";
  const json scenes = points_of(runs);
  const std::string csv = csv_of(scenes);
  EXPECT_TRUE(csv.starts_with("scene,split,label,iterations,n,psnr,psnr_least,psnr_most,psnr_dyn"))
      << csv;
  EXPECT_NE(csv.find("\nlego,val,fast,100,2,21.0,20.0,22.0,,,,"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",\"a \"\"big\"\", fast card\"\n"), std::string::npos) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  const long heading_end = long(csv.find('\n')), last_line = long(csv.rfind("\nlego"));
  EXPECT_EQ(std::count(csv.begin(), csv.begin() + heading_end, ',') + 1,
            std::count(csv.begin() + last_line, csv.end(), ','))
      << "as many fields as headings, and a comma in \"cpu, 2 threads\"";
}

}  // namespace
}  // namespace tessera
