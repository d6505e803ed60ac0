// Exports of scenes with far Gaussians: the others keep the error that they have without these, and
// what is left out is counted. Scenes without far Gaussians have the same bytes as ever.
#include "static3d/transform/far_gaussians.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "ingest/files/atomic_file.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/frame_sequence.h"
#include "static3d/formats/splat_formats.h"
#include "static3d/tessera4d/tessera4d.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/static3d/formats/splat_comparison.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/tessera4d_input.h"

namespace tessera::testing {
namespace {

/// `far` Gaussians in random directions, the nearest at `distance`, each 1.5 times further than the
/// one before; they are spread among the others.
GaussianSet with_far(const GaussianSet& set, int64_t far, float distance) {
  GaussianSet out = set.clone_values();
  const GaussianSpans<float> values = out.values();
  std::mt19937 random(uint32_t(far) + 1);
  std::normal_distribution<float> normal;
  for (int64_t i = 0; i < far; ++i, distance *= 1.5f) {
    Vec3<float> direction(normal(random), normal(random), normal(random));
    direction = glm::normalize(direction);
    float* const mean = values.at(kMean, i * (set.count() / far));
    for (int k = 0; k < 3; ++k) mean[k] = distance * direction[k];
  }
  return out;
}

/// Rows of `set` that are in the core.
GaussianSet core_of(const GaussianSet& set) {
  const FarShells shells(set.values());
  std::vector<int64_t> rows;
  for (int64_t n = 0; n < set.count(); ++n)
    if (shells.of_mean(n) == 0) rows.push_back(n);
  return select_elements(set, rows);
}

/// The largest difference of a mean of `set` from the nearest one of `read` on any axis.
double worst_mean(const GaussianSet& set, const GaussianSet& read) {
  const std::vector<int64_t> rows = matched(set, read);
  double worst = 0;
  for (int64_t n = 0; n < set.count(); ++n)
    for (int k = 0; k < 3; ++k)
      worst = std::max(worst, std::abs(double(set.values().at(kMean, n)[k]) -
                                       read.values().at(kMean, rows[size_t(n)])[k]));
  return worst;
}

std::vector<SplatFormat> formats_with_a_range() {
  std::vector<SplatFormat> formats;
  for (const char* name : {"compressed", "spz", "sog"})
    if (is_built(splat_format(name))) formats.push_back(splat_format(name));
  return formats;
}

/// The bound of the error of means in the core, docs/reference/splat-formats.md. The core reaches
/// to four half extents, where that of .sog has grown with 1 + |x|.
double stated(const SplatFormat& format, const GaussianSet& set) {
  const double h = double(FarShells(set.values()).box().half_extent);
  const std::string name = format.name;
  return name == "compressed" ? h / 128 : name == "spz" ? 1.0 / 8192 + 1e-6 : 4 * h / 256;
}

// Bugs put back, each seen to fail: chunks of any shells; `holds` always true in rows_within;
// shells from the core outwards.
TEST(FarGaussians, OthersKeepTheStatedError) {
  const ScratchFolder folder;
  const GaussianSet set = set_to_write(600);
  for (const SplatFormat& format : formats_with_a_range())
    for (const int64_t far : {1, 2, 5, 20})
      for (const float distance : {30.0f, 3000.0f, 5e4f, 1e9f, 1e30f}) {
        SCOPED_TRACE(fmt::format("{}, {} from {}", format.name, far, distance));
        const GaussianSet spoilt = with_far(set, far, distance);
        const auto path = folder / (std::string("a") + format.extension);
        const int64_t left_out = save_splat_file(format, path, spoilt, {1});
        const SplatFile read = load_splat_file(path);
        EXPECT_TRUE(read.warnings.empty());
        EXPECT_EQ(read.set.count() + left_out, 600);
        EXPECT_LE(left_out, far);
        if (std::string(format.name) == "spz" && 100 * far > 600) continue;  // of coarser steps
        EXPECT_LE(worst_mean(core_of(spoilt), read.set), stated(format, spoilt));
      }
}

// Bugs put back, each seen to fail: chunks of any shells; shells from the core outwards.
TEST(FarGaussians, FillChunksOfTheirOwnWhereTheyAreMany) {
  const ScratchFolder folder;
  GaussianSet set = set_to_write(2000);
  for (int64_t n = 0; n < 700; ++n) set.values().at(kMean, n)[0] += 3000;
  const int64_t left_out = save_splat_file(splat_format("compressed"), folder / "a.ply", set, {0});
  EXPECT_LE(left_out, 255);
  const SplatFile read = load_splat_file(folder / "a.ply");
  EXPECT_EQ(read.set.count() + left_out, 2000);
  EXPECT_LE(worst_mean(core_of(set), read.set), stated(splat_format("compressed"), set));
}

// A background with some hundred Gaussians in each shell, distances evenly in their logarithms.
// Bug put back: a chunk of one shell alone; seen to fail.
TEST(FarGaussians, OfAContinuousBackgroundStay) {
  const ScratchFolder folder;
  GaussianSet set = set_to_write(7000);
  for (int64_t n = 0; n < 3000; ++n) {
    float* const mean = set.values().at(kMean, n);
    const Vec3<float> direction = glm::normalize(Vec3<float>(mean[0], mean[1], mean[2]));
    for (int k = 0; k < 3; ++k) mean[k] = direction[k] * std::pow(200.0f, float(n) / 3000);
  }
  EXPECT_EQ(save_splat_file(splat_format("compressed"), folder / "a.ply", set, {0}), 0);
  EXPECT_EQ(load_splat_file(folder / "a.ply").set.count(), 7000);
}

// Bugs put back, each seen to fail: of_colour always 0; entries of a codebook over all values.
TEST(FarGaussians, ColoursOfOthersStay) {
  const ScratchFolder folder;
  GaussianSet set = set_to_write(600);
  set.values().at(kSh, 77)[1] = 1e5f;
  for (const SplatFormat& format : formats_with_a_range()) {
    SCOPED_TRACE(format.name);
    const auto path = folder / (std::string("a") + format.extension);
    const int64_t left_out = save_splat_file(format, path, set, {0});
    const SplatFile read = load_splat_file(path);
    EXPECT_EQ(read.set.count() + left_out, 600);
    const std::vector<int64_t> rows = matched(set, read.set);
    for (int64_t n = 0; n < 600; ++n)
      for (int c = 0; n != 77 && c < 3; ++c)
        EXPECT_NEAR(read.set.values().at(kSh, rows[size_t(n)])[c], set.values().at(kSh, n)[c], 0.03)
            << n;
  }
}

// Bug put back: save_splat_file counts only what is not finite; seen to fail.
TEST(FarGaussians, AreCountedBesideWhatIsNotFinite) {
  const ScratchFolder folder;
  GaussianModel model = random_model(0, 0);
  model.static_set = with_far(set_to_write(600), 1, 1e35f);
  for (int64_t n = 0; n < 600; ++n) *model.static_set.values().at(kOpacityLogit, n) = 1;
  model.static_set.values().at(kMean, 5)[2] = NAN;
  model.static_set.values().at(kMean, 6)[0] = -INFINITY;
  for (const SplatFormat& format : formats_with_a_range()) {
    SCOPED_TRACE(format.name);
    const SequenceReport report = export_sequence(model, folder / format.name, {0}, format);
    EXPECT_EQ(report.non_finite, 2);
    const int64_t far = std::string(format.name) == "sog" ? 0 : 1;  // logarithms reach it
    EXPECT_EQ(report.out_of_range, far);
    EXPECT_EQ(report.frames[0].gaussians, 598 - far);
  }
  EXPECT_EQ(export_sequence(model, folder / "ply", {0}, splat_format("ply")).out_of_range, 0);
}

// Bug put back: a core of half an extent; seen to fail.
TEST(FarGaussians, NoneLeaveTheOrderAndTheStepsAsTheyAre) {
  const ScratchFolder folder;
  const GaussianSet set = set_to_write(600);
  const HeldRows held = rows_in_chunks(set.values(), 256);
  EXPECT_TRUE(held.beyond.empty());
  EXPECT_EQ(held.rows, morton_order(set.values()));
  GaussianSet wide = set.clone_values();
  for (float& x : wide.group(kMean).value.span()) x *= 700;  // four half extents are beyond 2047
  EXPECT_EQ(save_splat_file(splat_format("spz"), folder / "a.spz", wide, {0}), 0);
  EXPECT_LE(worst_mean(wide, load_splat_file(folder / "a.spz").set), 1.0 / 8192 + 1e-4);
}

// Bug put back: the step of means as ever; seen to fail.
TEST(FarGaussians, ASceneFarFromTheOriginHasCoarserStepsInSpz) {
  const ScratchFolder folder;
  GaussianSet set = set_to_write(600);
  for (int64_t n = 0; n < 600; ++n) set.values().at(kMean, n)[1] += 5000;
  EXPECT_EQ(save_splat_file(splat_format("spz"), folder / "a.spz", set, {0}), 0);
  EXPECT_LE(worst_mean(set, load_splat_file(folder / "a.spz").set), 1.0 / 2048 + 1e-3);
  for (int64_t n = 0; n < 600; ++n) set.values().at(kMean, n)[1] += 1e6f;
  expect_input_error([&] { save_splat_file(splat_format("spz"), folder / "b.spz", set, {0}); },
                     {"b.spz", "1005000", "export as ply"});
}

// Bug put back: any mean in range; seen to fail.
TEST(FarGaussians, ASceneFarFromTheOriginKeepsItsErrorInSog) {
  if (!is_built(splat_format("sog"))) GTEST_SKIP() << "built without libwebp";
  const ScratchFolder folder;
  GaussianSet set = set_to_write(600);
  for (int64_t n = 1; n < 600; ++n) set.values().at(kMean, n)[1] += 5000;
  EXPECT_EQ(save_splat_file(splat_format("sog"), folder / "a.sog", set, {0}), 1);
  EXPECT_LE(worst_mean(core_of(set), load_splat_file(folder / "a.sog").set),
            stated(splat_format("sog"), set));
}

// Bug put back: one block for all; seen to fail.
TEST(FarGaussians, HaveABlockOfTheirOwnInTessera4d) {
  const ScratchFolder folder;
  GaussianModel model = random_model(0, 0);
  model.static_set = set_to_write(600);
  for (int64_t n = 0; n < 600; ++n) *model.static_set.values().at(kOpacityLogit, n) = 1;
  const std::string before = single_tessera4d(encode_tessera4d(model, {}));
  EXPECT_EQ(encode_tessera4d(model, {}).blocks.size(), 1u);
  write_text_file(folder / "a.t4d", before);
  const double plain =
      worst_mean(model.static_set, load_tessera4d(folder / "a.t4d").model.static_set);
  model.static_set = with_far(model.static_set, 5, 1e9f);
  const Tessera4dFile file = encode_tessera4d(model, {});
  EXPECT_EQ(file.static_count, 600);
  write_text_file(folder / "b.t4d", single_tessera4d(file));
  const GaussianSet read = load_tessera4d(folder / "b.t4d").model.static_set;
  EXPECT_EQ(read.count(), 600);
  EXPECT_LE(worst_mean(core_of(model.static_set), read), 1.05 * plain);
}

}  // namespace
}  // namespace tessera::testing
