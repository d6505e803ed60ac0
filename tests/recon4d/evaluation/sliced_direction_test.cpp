// The option sliced_direction of a model: in images, in its file, in slices. Its gradient is tested
// in tests/kernels.
#include "recon4d/model/model_file.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/support/lift.h"

namespace tessera::testing {
namespace {

/// Share of the values that differ by more than expect_same_image lets pass, of which it allows
/// 0.002.
double share_that_differs(const RenderedImage& a, const RenderedImage& b) {
  int64_t count = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i) count += std::abs(a.rgb[i] - b.rgb[i]) > 1e-4f;
  return double(count) / double(a.rgb.size());
}

GaussianModel unsliced(const GaussianModel& model) {
  GaussianModel other = clone(model);
  other.drawing.sliced_direction = false;
  return other;
}

View at_time(double time) {
  View view = three_views()[0];
  view.time = time;
  return view;
}

// Bug put back: render_options leaves it at its default; seen to fail.
TEST(SlicedDirection, ChangesTheImageOfWhatMovesAndOnlyThat) {
  const GaussianModel moving = random_model(0, 60), fixed = random_model(60, 0);
  const View view = at_time(0.8);
  const RenderedImage sliced = render_one(moving, view), other = render_one(unsliced(moving), view);
  EXPECT_GT(coverage(sliced), 0.1);
  EXPECT_GT(share_that_differs(sliced, other), 0.1);
  EXPECT_EQ(sliced.alpha, other.alpha) << "only colours depend on it";
  EXPECT_TRUE(same_bits(render_one(fixed, view), render_one(unsliced(fixed), view)));

  GaussianModel uniform = clone(moving);  // one colour from everywhere
  uniform.drawing.sh_degree = 0;
  EXPECT_TRUE(same_bits(render_one(uniform, view), render_one(unsliced(uniform), view)));
}

/// A slice has no memory of the mean over time: see slice_model.
TEST(SlicedDirection, SlicesAreExactOnlyWithIt) {
  const GaussianModel model = random_model(20, 60), other = unsliced(model);
  for (double time : {0.1, 0.5, 0.8}) {
    const View view = at_time(time);
    expect_same_image(render_one(static_model(model, slice_model(model, time)), view),
                      render_one(model, view));
    EXPECT_GT(share_that_differs(render_one(static_model(other, slice_model(other, time)), view),
                                 render_one(other, view)),
              0.1);
  }
}

}  // namespace
}  // namespace tessera::testing
