// The pair and velocity forms describe the same family of Gaussians: converted sets render as
// before. Files, worlds, slices and checkpoints of velocity sets are tested too.
#include "static3d/transform/motion_form.h"

#include "recon4d/model/checkpoint.h"
#include "recon4d/model/model_file.h"
#include "static3d/transform/slicer.h"
#include "static3d/transform/world_change.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/support/lift.h"

namespace tessera::testing {
namespace {

/// Images of float sums of Gaussians whose shape was rounded once more: α moves by some 1e-5; a
/// faint splat may cross its cut-off.
void expect_same_images(const GaussianModel& a, const GaussianModel& b) {
  for (View view : three_views())
    for (double time : {0.1, 0.4, 0.5, 0.9}) {
      view.time = time;
      const RenderedImage x = render_one(a, view), y = render_one(b, view);
      EXPECT_GT(coverage(x), 0.05);
      size_t off = 0;
      for (size_t i = 0; i < x.rgb.size(); ++i) {
        const double difference = std::abs(double(x.rgb[i]) - double(y.rgb[i]));
        EXPECT_LT(difference, 1.2 / 255);
        off += difference > 1e-4;
      }
      EXPECT_LE(double(off), 0.002 * double(x.rgb.size()));
    }
}

// Bugs put back, each seen to fail: the time axis without σ_t in its spatial part; axes taken as
// rows.
TEST(MotionForm, ConvertedSetsRenderAsBefore) {
  for (const SetForm form : kDynamicForms) {
    const GaussianModel model = random_model(10, 150, 31, 4, form);
    const SetForm other = form == SetForm::kPair ? SetForm::kVelocity : SetForm::kPair;
    GaussianModel converted = clone(model);
    converted.dynamic_set = in_form(model.dynamic_set, other);
    EXPECT_EQ(converted.dynamic_set.form(), other);
    ASSERT_EQ(converted.dynamic_set.count(), 150);
    expect_same_images(model, converted);
    GaussianModel back = clone(model);
    back.dynamic_set = in_form(converted.dynamic_set, form);
    expect_same_images(model, back);
  }
}

TEST(MotionForm, AVelocityComesBackToRounding) {
  const GaussianModel model = random_model(0, 200, 33, 4, SetForm::kVelocity);
  const GaussianSet back = in_form(in_form(model.dynamic_set, SetForm::kPair), SetForm::kVelocity);
  for (int64_t i = 0; i < 600; ++i)
    EXPECT_NEAR(back.group(kVelocity).value[i], model.dynamic_set.group(kVelocity).value[i], 1e-5);
  for (int64_t n = 0; n < 200; ++n) {
    EXPECT_NEAR(back.group(kLogScaleTime).value[n], model.dynamic_set.group(kLogScaleTime).value[n],
                1e-5);
    float sum[2] = {};  // the axes may come in another order
    for (int k = 0; k < 3; ++k) {
      sum[0] += back.group(kLogScale).value[3 * n + k];
      sum[1] += model.dynamic_set.group(kLogScale).value[3 * n + k];
    }
    EXPECT_NEAR(sum[0], sum[1], 1e-4);
  }
}

TEST(MotionForm, UnsoundGaussiansAreLeftOut) {
  GaussianModel model = random_model(0, 5);
  model.dynamic_set.group(kMean).value[3] = NAN;
  for (int k = 0; k < 4; ++k) model.dynamic_set.group(kRotationRight).value[4 * 3 + k] = 0;
  EXPECT_EQ(in_form(model.dynamic_set, SetForm::kVelocity).count(), 3);
}

TEST(MotionForm, SlicesWorldsAndLiftsOfVelocitySets) {
  const GaussianModel model = random_model(20, 60, 35, 4, SetForm::kVelocity);
  for (double time : {0.3, 0.6}) {
    View view = three_views()[0];
    view.time = time;
    expect_same_image(render_one(static_model(model, slice_model(model, time)), view),
                      render_one(model, view));
  }
  Similarity world;  // Bug put back: velocities not scaled with the world; seen to fail.
  world.scale = 2.5;
  world.rotation = rotation_matrix(normalised(Vec4<double>(0.3, -0.5, 0.7, 0.2)));
  world.translation = {1, -2, 0.5};
  GaussianModel moved = model_in_world(world, model);
  for (View view : three_views()) {
    const RenderedImage before = render_one(model, view);
    const RenderedImage after = render_one(moved, {camera_in_world(world, view.camera), view.time});
    size_t off = 0;
    for (size_t i = 0; i < before.rgb.size(); ++i)
      off += std::abs(before.rgb[i] - after.rgb[i]) > 1e-4f;
    EXPECT_LE(double(off), 0.002 * double(before.rgb.size()));
  }
  GaussianModel lifted = clone(model);
  lifted.dynamic_set = lift_to_4d(model.static_set, 8, SetForm::kVelocity);
  lifted.static_set = GaussianSet(SetForm::kStatic, 4);
  const GaussianModel still = static_model(model, model.static_set.clone_values());
  expect_same_image(render_one(lifted, three_views()[1]), render_one(still, three_views()[1]));
}

// Bug put back: the file's form ignored; seen to fail.
TEST(MotionForm, FilesKeepTheForm) {
  const TemporaryFolder folder;
  const GaussianModel model = random_model(4, 7, 37, 4, SetForm::kVelocity);
  save_model(folder / "a.ply", model);
  const GaussianModel reloaded = load_model(folder / "a.ply");
  EXPECT_EQ(reloaded.dynamic_set.form(), SetForm::kVelocity);
  EXPECT_TRUE(same_bits(reloaded.dynamic_set, model.dynamic_set));

  TrainState state;
  state.model = clone(model);
  for (int k = 0; k < 2; ++k) {
    state.set(k).ensure_moments();
    state.statistics[k].reset(state.set(k).count());
  }
  save_checkpoint(folder / "c.ckpt", state, TrainOptions(), {});
  const Checkpoint checkpoint = load_checkpoint(folder / "c.ckpt");
  EXPECT_TRUE(same_bits(checkpoint.state.model.dynamic_set, model.dynamic_set));
}

}  // namespace
}  // namespace tessera::testing
