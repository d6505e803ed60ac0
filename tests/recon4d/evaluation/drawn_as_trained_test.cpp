// What: models remember how they are to be drawn: 2D filter, truncation, temporal filter, the
//       scale of training.
// Not: what these do to an image (tests/kernels), nor checkpoints (train_checkpoint_test.cpp).
#include "recon4d/model/model_file.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

GaussianModel unusual(const GaussianModel& model) {
  GaussianModel other = clone(model);
  other.filter_2d = true, other.truncation_sigma = 2.25, other.truncation_by_falloff = true;
  other.train_scale = 0.5, other.time_filter = 0.0375;
  return other;
}

// Bugs put back, each seen to fail: a comment written with its default; a member not copied.
TEST(DrawnAsTrained, IsKeptInTheModelFileAndInCopies) {
  const TemporaryFolder folder;
  save_model(folder / "unusual.ply", unusual(random_model(3, 5)));
  const GaussianModel loaded = load_model(folder / "unusual.ply");
  const GaussianModel copy = loaded.clone_values();
  for (const GaussianModel* model : {&loaded, &copy}) {
    EXPECT_TRUE(model->filter_2d);
    EXPECT_EQ(model->truncation_sigma, 2.25);
    EXPECT_TRUE(model->truncation_by_falloff);
    EXPECT_EQ(model->train_scale, 0.5);
    EXPECT_EQ(model->time_filter, 0.0375);
  }
}

// Bug put back: render_options leaves one of them at its default; seen to fail.
TEST(DrawnAsTrained, EachChangesTheImage) {
  const GaussianModel model = random_model(30, 30);
  const View view = three_views()[0];
  const RenderedImage usual = render_one(model, view);
  GaussianModel other = clone(model);
  other.filter_2d = true;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
  other = clone(model);
  other.truncation_sigma = 2;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
  other = clone(model);
  other.truncation_by_falloff = true;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
  other = clone(model);
  other.time_filter = 0.1;
  EXPECT_FALSE(same_bits(render_one(other, view), usual));
}

TEST(DrawnAsTrained, IsUsualInFilesThatDoNotSay) {
  const TemporaryFolder folder;
  save_model(folder / "model.ply", random_model(3, 5));
  std::string bytes = read_bytes(folder / "model.ply");
  for (const std::string key : {"truncation", "filter_2d", "train_scale", "time_filter"}) {
    const size_t at = bytes.find("comment " + key + " ");
    ASSERT_NE(at, std::string::npos) << key;
    bytes.erase(at, bytes.find('\n', at) + 1 - at);
  }
  write_bytes(folder / "earlier.ply", bytes);
  const GaussianModel earlier = load_model(folder / "earlier.ply");
  EXPECT_FALSE(earlier.filter_2d || earlier.truncation_by_falloff);
  EXPECT_EQ(earlier.truncation_sigma, kTruncationSigma);
  EXPECT_EQ(earlier.train_scale, 1);
  EXPECT_EQ(earlier.time_filter, 0);
}

}  // namespace
}  // namespace tessera::testing
