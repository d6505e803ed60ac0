// The numbered sequence: names, validity, manifest, and frames that render as the model does.
// Source: failure modes E1, E3, E4, E7.
#include "static3d/formats/frame_sequence.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "ingest/files/ply.h"
#include "static3d/formats/splat_file.h"
#include "static3d/transform/scene_box.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

std::vector<double> even_times(int count) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(count == 1 ? 0.5 : double(i) / (count - 1));
  return times;
}

std::vector<std::string> files_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Values of a splat file that are NaN or infinite, counted from its raw columns.
int64_t non_finite_values(const std::filesystem::path& path) {
  int64_t count = 0;
  const PlyFile file = read_ply(path);
  for (const PlyColumn& column : file.elements.at(0).columns)
    for (double value : column.values) count += !std::isfinite(value);
  return count;
}

nlohmann::json manifest_of(const std::filesystem::path& folder) {
  return nlohmann::json::parse(read_bytes(folder / "manifest.json"));
}

// Failure mode E1. Bug put back: frames sliced at index/T instead of their time; seen to fail.
TEST(Sequence, FramesRenderAsTheModelDoes) {
  const TemporaryFolder folder;
  const GaussianModel model = random_model(40, 60);
  const std::vector<double> times = {0, 0.3, 0.55, 1};
  export_sequence(model, folder.path(), times, splat_format("ply"));
  for (size_t i = 0; i < times.size(); ++i) {
    SplatFile frame = load_splat_file(folder / fmt::format("frame_{:04}.ply", i));
    EXPECT_TRUE(frame.warnings.empty());
    View view = three_views()[0];
    view.time = times[i];
    expect_same_image(render_one(static_model(model, std::move(frame.set)), view),
                      render_one(model, view));
  }
}

// Failure mode E3. Bug put back: is_valid_element always true; seen to fail.
TEST(Sequence, NothingBrokenLeavesTheProgram) {
  const TemporaryFolder folder;
  GaussianModel model = random_model(40, 40);
  model.static_set.group(kMean).value[0] = NAN;
  model.static_set.group(kSh).value[48 + 7] = INFINITY;
  model.dynamic_set.group(kLogScale).value[3] = -INFINITY;
  model.dynamic_set.group(kSh).value[2 * 48] = NAN;
  for (int k = 0; k < 4; ++k) model.dynamic_set.group(kRotationRight).value[12 + k] = 0;
  model.static_set.group(kOpacityLogit).value[2] = -9;  // never drawn
  model.static_set.group(kMean).value[3 * 3] = 1000;    // far outside
  for (int64_t n = 0; n < 40; ++n) model.dynamic_set.group(kMeanTime).value[n] = 0.5f;
  const SequenceReport report = export_sequence(model, folder.path(), {0.5}, splat_format("ply"));
  EXPECT_EQ(report.non_finite, 5);
  EXPECT_EQ(report.below_cutoff, 1);
  EXPECT_EQ(report.far_outliers, 1);
  EXPECT_EQ(report.frames[0].gaussians, 80 - 6);
  EXPECT_EQ(non_finite_values(folder / "frame_0000.ply"), 0);
  const nlohmann::json manifest = manifest_of(folder.path());
  EXPECT_EQ(manifest["counters"]["non_finite"], 5);
  EXPECT_EQ(manifest["frames"][0]["gaussians"], 74);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_LT(std::abs(double(manifest["bounds"]["max"][axis])), 10);

  PlyFile injected = read_ply(folder / "frame_0000.ply");
  injected.elements[0].columns[5].values[11] = NAN;
  write_ply(folder / "injected.ply", injected);
  EXPECT_EQ(non_finite_values(folder / "injected.ply"), 1) << "the count above sees nothing";
}

// Failure mode E4. Bug put back: names without padding; seen to fail.
TEST(Sequence, NamesSortByTimeWithoutAGap) {
  const TemporaryFolder folder;
  const GaussianModel model = random_model(2, 2);
  for (int count : {13, 5}) {  // the shorter one replaces the longer
    export_sequence(model, folder.path(), even_times(count), splat_format("ply"));
    const std::vector<std::string> names = files_in(folder.path());
    ASSERT_EQ(names.size(), size_t(count) + 1);
    const nlohmann::json manifest = manifest_of(folder.path());
    ASSERT_EQ(manifest["frames"].size(), size_t(count));
    EXPECT_EQ(manifest["count"], count);
    double last = -1;
    for (int i = 0; i < count; ++i) {
      EXPECT_EQ(names[size_t(i)], fmt::format("frame_{:04}.ply", i));
      EXPECT_EQ(manifest["frames"][i]["file"], names[size_t(i)]);
      EXPECT_GT(double(manifest["frames"][i]["time"]), last);
      last = manifest["frames"][i]["time"];
    }
  }
}

// Failure mode E7. Bug put back: constant_ids left out of the manifest; seen to fail.
TEST(Sequence, ManifestHasRateTimesAndChangingIds) {
  const TemporaryFolder folder;
  GaussianModel model = random_model(3, 3);
  model.time_axis = {2, 4};
  std::vector<int64_t> progress;
  const SequenceReport report = export_sequence(
      model, folder.path(), even_times(9), splat_format("ply"), [&](int64_t done, int64_t total) {
        progress.push_back(done);
        EXPECT_EQ(total, 9);
      });
  EXPECT_EQ(progress.back(), 9);
  const nlohmann::json manifest = manifest_of(folder.path());
  EXPECT_FALSE(manifest.value("constant_ids", true));
  EXPECT_EQ(manifest["fps"], 2.0);
  EXPECT_EQ(manifest["frames"][8]["source_time"], 6.0);
  EXPECT_EQ(manifest["bytes"], report.bytes);
  export_sequence(model, folder.path(), {0.5}, splat_format("ply"));
  EXPECT_TRUE(manifest_of(folder.path())["fps"].is_null());
}

TEST(Sequence, RefusesNoTimesAndTimesThatDoNotAscend) {
  const TemporaryFolder folder;
  const GaussianModel model = random_model(1, 1);
  expect_input_error([&] { export_sequence(model, folder.path(), {}, splat_format("ply")); },
                     {"at least one time"});
  expect_input_error(
      [&] {
        export_sequence(model, folder.path(), {0, 0.5, 0.5}, splat_format("ply"));
      },
      {"ascend", "0.5 after 0.5"});
  write_bytes(folder / "file", "");
  expect_input_error([&] { export_sequence(model, folder / "file", {0}, splat_format("ply")); },
                     {"file"});
}

TEST(Sequence, AnEmptyModelIsASequenceOfEmptyFrames) {
  const TemporaryFolder folder;
  const SequenceReport report =
      export_sequence(random_model(0, 0), folder.path(), even_times(3), splat_format("ply"));
  EXPECT_EQ(report.max_gaussians, 0);
  EXPECT_TRUE(manifest_of(folder.path())["bounds"].is_null());
  EXPECT_EQ(load_splat_file(folder / "frame_0002.ply").set.count(), 0);
}

TEST(SceneBox, IsNotMovedByStrayGaussians) {
  GaussianModel model = random_model(300, 300);
  const SceneBox before = scene_box(model);
  for (int64_t n = 0; n < 30; ++n) model.static_set.group(kMean).value[3 * n] = 1e5f;
  const SceneBox after = scene_box(model);
  EXPECT_NEAR(before.half_extent, 0.9, 0.15);
  EXPECT_NEAR(after.half_extent, before.half_extent, 0.15);
  EXPECT_FALSE(after.is_far({8, 0, 0}, 10));
  EXPECT_TRUE(after.is_far({0, -12, 0}, 10));
  EXPECT_FALSE(scene_box(random_model(1, 0)).is_far({1e9f, 0, 0}, 10));
}

}  // namespace
}  // namespace tessera::testing
