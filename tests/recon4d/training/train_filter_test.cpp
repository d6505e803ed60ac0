// The 3D filter in a training: its sizes follow the set and are kept by checkpoints, exported
// models include it in their scales, and scales stay above it.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/pipeline.h"
#include "recon4d/evaluation/render.h"
#include "tests/recon4d/model/handmade_set.h"
#include "tests/support/resume.h"

namespace tessera::testing {
namespace {

TrainOptions filtered_options(Filter3d filter) {
  TrainOptions options = tiny_options();
  options.filter_3d = filter;
  options.filter_2d = true;
  options.opacity_reset_interval = 15;
  return options;
}

// Bugs put back, each seen to fail: sizes not in the checkpoint; not permuted by `reorder`.
TEST(TrainFilter, ResumeIsBitEqual) {
  const Scene scene = tiny_capture();
  for (const Filter3d filter : {Filter3d::kMip, Filter3d::kClamp}) {
    const TrainOptions options = filtered_options(filter);
    Training whole(scene, options);
    whole.run();
    for (const int64_t half : {10, 21}) {  // before a reordering; between two measurements
      SCOPED_TRACE(std::string(name_of(filter)) + std::to_string(half));
      testing::expect_resumes(scene, options, half, whole, [](const TrainState& state) {
        EXPECT_TRUE(state.has_filter_sizes());
      });
    }
  }
}

TEST(TrainFilter, SizesAreReorderedWithTheSet) {
  // Bug put back: sizes left in their places; seen to fail.
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  for (const SetForm form : {SetForm::kStatic, SetForm::kPair}) {
    HandmadeSet made(form, 50);
    made.statistics.filter_size.resize(50);
    for (int64_t n = 0; n < 50; ++n) made.statistics.filter_size[n] = float(n) + 0.5f;
    reorder(*backend, made.set, made.statistics);
    const std::vector<Tag> tags = made.tags();
    EXPECT_FALSE(std::is_sorted(tags.begin(), tags.end()));
    for (int64_t n = 0; n < 50; ++n)
      EXPECT_EQ(made.statistics.filter_size[n], float(tags[size_t(n)]) + 0.5f);
  }
}

// Bugs put back, each seen to fail: the model not baked where it is handed out; baked twice.
TEST(TrainFilter, ModelsThatLeaveTheTrainerHaveItBakedIn) {
  const Scene scene = tiny_capture();
  TrainOptions options = filtered_options(Filter3d::kMip);
  options.opacity_reset_interval = 0;  // nothing is faint
  Training training(scene, options);
  training.run(22);
  const TrainState& state = training.state();
  const std::vector<View> views = {{scene.frames[2].camera, scene.frames[2].time}};
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  Pipeline<float> pipeline(*backend);
  const Images<float>& drawn =
      pipeline.forward(drawn_values(state, 0, options), drawn_values(state, 1, options), views,
                       render_options(state.model));
  const GaussianModel model = baked_model(state, options);
  const RenderedImage baked = render_views(*backend, model, views)[0];
  const RenderedImage raw = render_views(*backend, state.model, views)[0];
  double worst = 0, matters = 0;
  for (size_t i = 0; i < baked.rgb.size(); ++i) {
    worst = std::max(worst, std::abs(double(baked.rgb[i]) - drawn.colour[int64_t(i)]));
    matters = std::max(matters, std::abs(double(raw.rgb[i]) - drawn.colour[int64_t(i)]));
  }
  EXPECT_LE(worst, 1e-5);
  EXPECT_GT(matters, 1e-2) << "the filter matters";
}

/// No training view is nearer than 2 to a blob, and focal lengths are less than 40 pixels.
constexpr double kSmallestFilter = 0.4472 * 2 / 40;

float smallest_scale(const GaussianModel& model) {
  float least = INFINITY;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    for (const float s : set->group(kLogScale).value) least = std::min(least, s);
  return std::exp(least);
}

// Bugs put back, each seen to fail: not baked at the end; scales not raised; raised before the
// optimizer's step.
TEST(TrainFilter, NoGaussianIsFinerAtTheEnd) {
  const Scene scene = tiny_capture();
  for (const Frame& frame : scene.frames) ASSERT_LT(frame.camera.fl_x, 40);
  TrainOptions options = filtered_options(Filter3d::kNone);
  options.lr_scale = 0.1;  // fast enough to shrink below
  Training plain(scene, options);
  EXPECT_LT(smallest_scale(plain.run().model()), kSmallestFilter);
  for (const Filter3d filter : {Filter3d::kMip, Filter3d::kClamp}) {
    options.filter_3d = filter;
    Training training(scene, options);
    EXPECT_GT(smallest_scale(training.run().model()), kSmallestFilter) << name_of(filter);
    EXPECT_FALSE(training.state().has_filter_sizes()) << "measured and used up";
  }
  Training raised(scene, options);
  for (int64_t i = 1; i < 40; i += 6) {
    raised.run(i);
    const TrainState& state = raised.state();
    for (int k = 0; k < 2; ++k)
      for (int64_t n = 0; n < state.set(k).count(); ++n)
        for (int axis = 0; axis < 3; ++axis)
          ASSERT_GE(state.set(k).values().at(kLogScale, n)[axis],
                    std::log(state.statistics[k].filter_size[n]));
  }
}

// Bug put back: sizes left out by the trainer's reset; seen to fail.
TEST(TrainFilter, ResetOpacityIsThatAfterTheFilter) {
  const Scene scene = tiny_capture();
  TrainOptions options = filtered_options(Filter3d::kMip);
  options.lr_opacity = 0;
  Training training(scene, options);
  training.run(16);  // one step after the reset
  const GaussianModel model = baked_model(training.state(), options);
  double above = 0, limited = 0;  // of all: some were fainter already
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    for (const float logit : set->group(kOpacityLogit).value) {
      const double opacity = 1 / (1 + std::exp(-double(logit)));
      above += opacity > 0.011;
      limited += std::abs(opacity - 0.01) < 1e-3;
    }
  // at 0.01 but for one step of the scales
  EXPECT_EQ(above, 0);
  EXPECT_GT(limited, 0.8 * double(model.count()));
}

}  // namespace
}  // namespace tessera::testing
