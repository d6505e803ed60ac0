// The Tessera 4D file: bit-equal when lossless, within its stated steps when lossy, and every
// Gaussian is in the blocks of the timesteps at which it is rendered. Source:
// docs/reference/tessera4d.md; failure modes E1, E2, E3.
#include "static3d/tessera4d/tessera4d.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/load_gaussian.h"
#include "recon4d/model/element_edits.h"
#include "static3d/tessera4d/block.h"
#include "static3d/tessera4d/segments.h"
#include "static3d/transform/motion_form.h"
#include "static3d/transform/scene_box.h"
#include "static3d/transform/slicer.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/tessera4d_input.h"

namespace tessera::testing {
namespace {

/// A clip of eight seconds whose dynamic Gaussians have extents from a quarter of a second to
/// infinity.
GaussianModel clip_model(uint64_t seed = 7, int64_t moving = 300) {
  GaussianModel model = random_model(60, moving, seed, 16, SetForm::kVelocity);
  model.time_axis = {0, 8};
  Random random(seed + 1);
  const GaussianSpans<float> set = model.dynamic_set.values();
  for (int64_t n = 0; n < set.count; ++n) {
    *set.at(kMeanTime, n) = float(random.uniform(-0.1, 1.1));
    *set.at(kLogScaleTime, n) = float(std::log(random.uniform(0.01, 1) * random.uniform(0, 1)));
    *set.at(kOpacityLogit, n) = float(random.uniform(-3, 4));
  }
  return model;
}

Tessera4dInput through_folder(const GaussianModel& model, const Tessera4dOptions& options = {}) {
  ScratchFolder folder;
  write_tessera4d_folder(folder.path(), encode_tessera4d(model, options));
  return load_tessera4d(folder.path());
}

Tessera4dOptions lossless() {
  Tessera4dOptions options;
  options.lossless = true;
  return options;
}

/// Rows of all groups as bytes, sorted: sets that differ in order alone are equal.
std::vector<std::string> sorted_rows(const GaussianSet& set) {
  std::vector<std::string> rows(size_t(set.count()));
  const GaussianSpans<const float> values = set.values();
  for (int64_t n = 0; n < set.count(); ++n)
    for (int g = 0; g < set.groups(); ++g)
      rows[size_t(n)].append(reinterpret_cast<const char*>(values.at(Group(g), n)),
                             sizeof(float) * size_t(set.width(Group(g))));
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// The Gaussians of a dynamic set that are rendered within the clip.
GaussianSet drawn_rows(const GaussianModel& model) {
  const GaussianSpans<const float> set = model.dynamic_set.values();
  std::vector<int64_t> rows;
  for (int64_t n = 0; n < set.count; ++n)
    if (drawn_in_clip(*set.at(kMeanTime, n), *set.at(kLogScaleTime, n),
                      sigmoid(double(*set.at(kOpacityLogit, n))), model.cutoff<double>()))
      rows.push_back(n);
  return select_elements(model.dynamic_set, rows);
}

View view_at(double time) {
  return {look_at({3.1, 0.7, -2.9}, {0, 0, 0}, 48, 36, 60), time};
}

double psnr_at(const GaussianModel& a, const GaussianModel& b, double time) {
  const RenderedImage x = render_one(a, view_at(time)), y = render_one(b, view_at(time));
  double sum = 0;
  for (size_t i = 0; i < x.rgb.size(); ++i) sum += std::pow(double(x.rgb[i]) - y.rgb[i], 2);
  return -10 * std::log10(sum / double(x.rgb.size()));
}

// Bug put back: the anchor's shift applied to files without loss; seen to fail.
TEST(Tessera4d, WithoutLossEveryGaussianIsBitEqual) {
  const GaussianModel model = clip_model();
  const Tessera4dInput read = through_folder(model, lossless());
  EXPECT_EQ(sorted_rows(read.model.static_set), sorted_rows(model.static_set));
  const GaussianSet drawn = drawn_rows(model);
  ASSERT_LT(drawn.count(), model.dynamic_set.count());  // some never are
  EXPECT_EQ(sorted_rows(read.model.dynamic_set), sorted_rows(drawn));
  EXPECT_EQ(read.model.drawing.sh_degree, model.drawing.sh_degree);
  EXPECT_EQ(read.model.background, model.background);
  EXPECT_EQ(read.model.time_axis.duration, model.time_axis.duration);
  EXPECT_EQ(read.model.drawing.near_plane, model.drawing.near_plane);
  EXPECT_EQ(read.model.drawing.far_plane, model.drawing.far_plane);
}

// Bug put back: quaternions not made of length 1 before their largest part is left out; seen to
// fail with 27 dB.
TEST(Tessera4d, ImagesStay) {
  const GaussianModel model = clip_model();
  const Tessera4dInput exact = through_folder(model, lossless()), read = through_folder(model);
  EXPECT_LT(read.bytes, exact.bytes * 3 / 4);
  for (double time : {0.0, 0.21, 0.5, 0.83, 1.0}) {
    expect_same_image(render_one(exact.model, view_at(time)), render_one(model, view_at(time)));
    EXPECT_GT(psnr_at(read.model, model, time), 45) << time;
  }
}

// Bug put back: logits read back through opacities; seen to fail (E2).
TEST(Tessera4d, WrittenAgainTheBlocksAreTheSame) {
  const Tessera4dFile first = encode_tessera4d(clip_model(), lossless());
  const Tessera4dFile again =
      encode_tessera4d(through_folder(clip_model(), lossless()).model, lossless());
  EXPECT_EQ(first.blocks, again.blocks);
}

TEST(Tessera4d, PairsAreReadBackAsTheirVelocities) {
  const GaussianModel model = random_model(20, 40, 3, 16, SetForm::kPair);
  const Tessera4dInput read = through_folder(model, lossless());
  ASSERT_EQ(read.model.dynamic_set.form(), SetForm::kVelocity);
  for (double time : {0.1, 0.6})
    expect_same_image(render_one(read.model, view_at(time)), render_one(model, view_at(time)));
}

/// One stream at a time, against the steps that docs/reference/tessera4d.md states.
class Steps : public ::testing::Test {
 protected:
  Steps() {
    const Span<float> velocity = model_.dynamic_set.group(kVelocity).value.span();
    for (int64_t i = 0; i < velocity.size; ++i) velocity.data[i] *= 60;  // timesteps matter then
    const GaussianSet drawn = drawn_rows(model_);
    const BlockRules rules{false, 3, model_.cutoff<double>()};
    block_ = encode_block(drawn, rules);
    read_ = decode_block(block_.bytes, block_.info, 3, true, "block");
    const GaussianSet floats = decode_of(encode_block(drawn, {true, 3, rules.cutoff}));
    truth_ = select_elements(floats, matching(floats));
  }
  static GaussianSet decode_of(const Block& block) {
    return decode_block(block.bytes, block.info, 3, false, "block");
  }
  /// Rows of `floats` by nearest SH: their steps are far below the differences of 48 numbers.
  std::vector<int64_t> matching(const GaussianSet& floats) const {
    std::vector<int64_t> rows;
    for (int64_t n = 0; n < read_.count(); ++n) {
      int64_t best = 0;
      const auto distance = [&](int64_t m) {
        double sum = 0;
        for (int i = 0; i < 48; ++i)
          sum += std::pow(double(read_.values().at(kSh, n)[i]) - floats.values().at(kSh, m)[i], 2);
        return sum;
      };
      for (int64_t m = 1; m < floats.count(); ++m)
        if (distance(m) < distance(best)) best = m;
      rows.push_back(best);
    }
    return rows;
  }
  double step(const std::string& name) const {
    for (const StreamInfo& stream : block_.info.streams)
      if (stream.name == name) return *std::max_element(stream.scale.begin(), stream.scale.end());
    return -1;
  }
  double worst(Group group, int first, int width) const {
    double most = 0;
    for (int64_t n = 0; n < read_.count(); ++n)
      for (int k = first; k < first + width; ++k)
        most = std::max(most, std::abs(double(read_.values().at(group, n)[k]) -
                                       double(truth_.values().at(group, n)[k])));
    return most;
  }

  GaussianModel model_ = clip_model();
  Block block_;
  GaussianSet read_{SetForm::kVelocity, 16}, truth_{SetForm::kVelocity, 16};
};

// Bug put back: floor in place of round; seen to fail for each.
TEST_F(Steps, ValuesAreOffByHalfAStepAtMost) {
  constexpr double kFloat = 1e-5;  // of rounding to float
  EXPECT_EQ(step("log_scale"), 1.0 / 32);
  EXPECT_LE(worst(kLogScale, 0, 3), 1.0 / 64 + kFloat);
  EXPECT_LE(worst(kSh, 0, 3), 1.0 / 256 + kFloat);
  EXPECT_LE(worst(kSh, 3, 9), 1.0 / 128 + kFloat);
  EXPECT_LE(worst(kSh, 12, 36), 1.0 / 64 + kFloat);
  EXPECT_LE(worst(kMeanTime, 0, 1), step("time_mean") / 2 + kFloat);
  EXPECT_LE(worst(kLogScaleTime, 0, 1), 1.0 / 128 + kFloat);
  EXPECT_LE(worst(kVelocity, 0, 3), step("velocity") / 2 + kFloat);
  for (int64_t n = 0; n < read_.count(); ++n)
    EXPECT_NEAR(sigmoid(double(*read_.values().at(kOpacityLogit, n))),
                sigmoid(double(*truth_.values().at(kOpacityLogit, n))), 0.5 / 255 + kFloat);
}

// Bug put back: positions at the unrounded timestep; seen to fail.
TEST_F(Steps, PathsStayWithinAStepWhereverTheyAreDrawn) {
  const double q = step("position");
  for (int64_t n = 0; n < read_.count(); ++n) {
    const auto mean_at = [&](const GaussianSet& set, double t, int k) {
      return double(set.values().at(kMean, n)[k]) +
             double(set.values().at(kVelocity, n)[k]) *
                 (t - double(*set.values().at(kMeanTime, n)));
    };
    const auto drawn = drawn_in_clip(
        *read_.values().at(kMeanTime, n), *read_.values().at(kLogScaleTime, n),
        sigmoid(double(*read_.values().at(kOpacityLogit, n))), model_.cutoff<double>());
    if (!drawn) continue;
    for (double t : {drawn->low, (drawn->low + drawn->high) / 2, drawn->high})
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(mean_at(read_, t, k), mean_at(truth_, t, k), q + 1e-5) << n << " at " << t;
  }
}

// Bug put back: the second-largest part left out; seen to fail.
TEST_F(Steps, RotationsAreWithinTheirAngle) {
  for (int64_t n = 0; n < read_.count(); ++n) {
    const Vec4<float> a = load4(read_.values().at(kRotation, n)),
                      b = glm::normalize(load4(truth_.values().at(kRotation, n)));
    EXPECT_NEAR(std::abs(glm::dot(a, b)), 1, 1e-6) << n;  // 1 − cos(0.0014)
  }
}

// Bug put back: intervals of blocks from the middle of the segment; seen to fail.
TEST(Tessera4d, BlocksOfATimestepHoldAllThatIsDrawnThen) {
  const GaussianModel model = clip_model();
  const Tessera4dFile file = encode_tessera4d(model, {});
  GaussianModel rules;
  const auto manifest = nlohmann::json::parse(file.manifest);
  const Tessera4dManifest info = manifest_from(manifest, "manifest.json", rules);
  const GaussianModel whole = through_folder(model).model;
  ASSERT_GT(info.blocks.size(), 8u);
  int64_t most_blocks = 0;
  for (int i = 0; i <= 40; ++i) {
    const double t = i / 40.0;
    GaussianModel part = clone(whole);
    part.static_set.resize(0);
    part.dynamic_set.resize(0);
    int64_t drawn = 0, blocks = 0;
    for (size_t b = 0; b < info.blocks.size(); ++b) {
      const BlockInfo& block = info.blocks[b];
      if (t < block.visible.low || t > block.visible.high) continue;
      GaussianSet set = decode_block(file.blocks[b].second, block, 3, true, "block");
      (block.moving ? part.dynamic_set : part.static_set) = std::move(set);
      drawn += Slicer(part).at(t).count();
      ++blocks;
      part.static_set.resize(0);
      part.dynamic_set.resize(0);
    }
    EXPECT_EQ(drawn, Slicer(whole).at(t).count()) << t;
    most_blocks = std::max(most_blocks, blocks);
  }
  EXPECT_LT(most_blocks, int64_t(info.blocks.size()));  // not everything at all times
}

// Bug put back: the next level's segments twice as long, not four times; seen to fail.
TEST(Tessera4d, GaussiansGoToTheLowestLevelThatIsLongEnough) {
  const double second = 1.0 / 10;
  EXPECT_EQ(cell_of({0.32, 0.36}, second), (TimeCell{1, 3}));
  EXPECT_EQ(cell_of({0.38, 0.45}, second), (TimeCell{1, 3}));  // reaches into the next
  EXPECT_EQ(cell_of({0.38, 0.6}, second), (TimeCell{2, 0}));
  EXPECT_EQ(cell_of({0.45, 0.8}, second), (TimeCell{2, 1}));
  EXPECT_EQ(cell_of({0.45, 0.95}, second), (TimeCell{3, 0}));  // 1.6 clips: one segment
  EXPECT_EQ(cell_of({0, 1}, second), (TimeCell{3, 0}));
  EXPECT_EQ(cell_of({0, 1}, 5.0), (TimeCell{1, 0}));
}

// Bug put back: a reach without the opacity's own end; seen to fail.
TEST(Tessera4d, DrawnWhereMarginalAndAlphaAllow) {
  const Cutoff<double> cutoff = make_cutoff<double>(kTruncationSigma, false);
  const double reach = std::sqrt(2 * std::log(20.0)), faint = std::sqrt(2 * std::log(255 * 0.01));
  auto drawn = drawn_in_clip(0.5, std::log(0.01), 0.9, cutoff);
  EXPECT_NEAR(drawn->low, 0.5 - 0.01 * reach, 1e-6);
  EXPECT_NEAR(drawn->high, 0.5 + 0.01 * reach, 1e-6);
  drawn = drawn_in_clip(0.5, std::log(0.01), 0.01, cutoff);
  EXPECT_NEAR(drawn->high, 0.5 + 0.01 * faint, 1e-6);
  EXPECT_FALSE(drawn_in_clip(0.5, std::log(0.01), 0.003, cutoff));
  EXPECT_FALSE(drawn_in_clip(1.1, std::log(0.01), 0.9, cutoff));
  EXPECT_EQ(drawn_in_clip(1.01, std::log(0.01), 0.9, cutoff)->high, 1.0);
}

// Bug put back: offsets of blocks counted from the file's beginning; seen to fail.
TEST(Tessera4d, ASingleFileHoldsTheSame) {
  ScratchFolder folder;
  const GaussianModel model = clip_model();
  const Tessera4dFile file = encode_tessera4d(model, {});
  write_text_file(folder / "scene.t4d", single_tessera4d(file));
  const Tessera4dInput one = load_tessera4d(folder / "scene.t4d"), many = through_folder(model);
  EXPECT_TRUE(same_bits(one.model.static_set, many.model.static_set));
  EXPECT_TRUE(same_bits(one.model.dynamic_set, many.model.dynamic_set));
  EXPECT_EQ(one.bytes, int64_t(std::filesystem::file_size(folder / "scene.t4d")));
}

// Bug put back: the temporal filter forgotten; seen to fail.
TEST(Tessera4d, TheTemporalFilterIsPartOfTheScale) {
  GaussianModel model = clip_model();
  model.drawing.time_filter = 4e-4;
  const Tessera4dInput read = through_folder(model, lossless());
  EXPECT_EQ(read.model.drawing.time_filter, 0);
  for (double time : {0.3, 0.7})
    expect_same_image(render_one(read.model, view_at(time)), render_one(model, view_at(time)));
}

// Bug put back: levels left out; seen to fail.
TEST(Tessera4d, ColoursThatFollowTimeAreThoseOfTheirTimestep) {
  const GaussianModel model = random_model_in_time(0, 1, 2, 5, 16, SetForm::kVelocity);
  const Tessera4dInput read = through_folder(model, lossless());
  ASSERT_EQ(read.model.dynamic_set.count(), 1);
  const GaussianSpans<const float> from = model.dynamic_set.values();
  const float* const levels = from.at(kShTime, 0);
  for (int i = 0; i < 48; ++i)
    EXPECT_NEAR(read.model.dynamic_set.values().at(kSh, 0)[i],
                from.at(kSh, 0)[i] + levels[i] + levels[48 + i], 1e-5);
}

// Bug put back: unsound Gaussians written; seen to fail (E3).
TEST(Tessera4d, WhatIsNotFiniteOrNeverDrawnIsLeftOutAndCounted) {
  GaussianModel model = clip_model();
  model.static_set.values().at(kMean, 3)[1] = NAN;
  model.dynamic_set.values().at(kVelocity, 5)[0] = INFINITY;
  *model.static_set.values().at(kOpacityLogit, 4) = -7;
  model.static_set.values().at(kMean, 6)[0] = 5e4f;
  const Tessera4dFile file = encode_tessera4d(model, {});
  const auto manifest = nlohmann::json::parse(file.manifest);
  EXPECT_EQ(manifest["dropped"]["non_finite"], 2);
  EXPECT_EQ(manifest["far_outliers"], 1);
  EXPECT_EQ(manifest["gaussians"]["static"], 58);
  EXPECT_LT(manifest["bounds"]["max"][0].get<double>(), 100);
  EXPECT_EQ(file.never_drawn + file.dynamic_count + file.static_count + file.non_finite,
            model.count());
}

// Bug put back: SH rows counted before sorting; seen to fail.
TEST(Tessera4d, UnusedDegreesTakeNoBytes) {
  GaussianModel model = clip_model();
  const GaussianSpans<float> set = model.static_set.values();
  for (int64_t n = 0; n < set.count; ++n)
    std::fill_n(set.at(kSh, n) + (n % 3 == 0 ? 3 : 12), n % 3 == 0 ? 45 : 36, 0.0f);
  const Tessera4dFile file = encode_tessera4d(model, lossless());
  const auto streams = nlohmann::json::parse(file.manifest)["blocks"][0]["streams"];
  std::map<std::string, int64_t> counts;
  for (const auto& stream : streams) counts[stream["name"]] = stream["count"];
  EXPECT_EQ(counts["colour"], 60);
  EXPECT_EQ(counts["sh1"], 40);
  EXPECT_EQ(counts.count("sh2"), 0u);
  EXPECT_EQ(sorted_rows(through_folder(model, lossless()).model.static_set),
            sorted_rows(model.static_set));
}

TEST(Tessera4d, AModelWithoutMotionIsOneBlock) {
  const GaussianModel model = random_model(30, 0);
  const Tessera4dFile file = encode_tessera4d(model, {});
  ASSERT_EQ(file.blocks.size(), 1u);
  EXPECT_EQ(through_folder(model).model.dynamic_set.count(), 0);
  EXPECT_EQ(encode_tessera4d(random_model(0, 0), {}).blocks.size(), 0u);
  EXPECT_EQ(through_folder(random_model(0, 0)).model.count(), 0);
}

TEST(Tessera4d, RigAndWorldTravel) {
  GaussianModel model = random_model(10, 10);
  model.prepared_from_source = {2, glm::dmat3{1.0}, {1, 2, 3}};
  model.drawing.filter_2d = true;
  Tessera4dOptions options;
  options.cameras = {{"cam07", view_at(0).camera}};
  options.fps = 30;
  const Tessera4dFile file = encode_tessera4d(model, options);
  const auto manifest = nlohmann::json::parse(file.manifest);
  const auto& camera = manifest["cameras"][0];
  EXPECT_EQ(camera["name"], "cam07");
  const Vec4<double> q(camera["rotation"][0], camera["rotation"][1], camera["rotation"][2],
                       camera["rotation"][3]);
  const glm::dvec3 forward = rotation_matrix(q) * glm::dvec3(0, 0, 1);
  const glm::dvec3 position(camera["position"][0], camera["position"][1], camera["position"][2]);
  EXPECT_NEAR(glm::dot(glm::normalize(-position), forward), 1, 1e-9);  // it looks at the origin
  EXPECT_EQ(manifest["time"]["fps"], 30);
  EXPECT_TRUE(manifest["splat"]["compensated"]);
  const Tessera4dInput read = through_folder(model, options);
  EXPECT_EQ(read.model.prepared_from_source, model.prepared_from_source);
  EXPECT_TRUE(read.model.drawing.filter_2d);
}

}  // namespace
}  // namespace tessera::testing
