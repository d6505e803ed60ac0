// Counts by SH degree and by temporal extent.
#include "static3d/tessera4d/model_histograms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "static3d/transform/motion_form.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

/// Zeros behind `degree`.
void cut(const GaussianSpans<float>& set, int64_t n, int degree) {
  const int kept = 3 * sh_coefficients(degree), all = 3 * set.coefficients;
  std::fill(set.at(kSh, n) + kept, set.at(kSh, n) + all, 0.0f);
  for (int i = 0; i < all * set.time_levels; ++i)
    if (i % all >= kept) set.at(kShTime, n)[i] = 0;
}

// Bugs put back: a band counted by its first coefficient alone; levels of time ignored; each
// seen to fail.
TEST(ModelHistograms, DegreesAreThoseThatHoldSomething) {
  GaussianModel model = random_model_in_time(4, 4, 2);
  for (int64_t n = 0; n < 4; ++n) {
    cut(model.static_set.values(), n, int(n));
    cut(model.dynamic_set.values(), n, 0);
  }
  float* last = model.static_set.values().at(kSh, 0);
  last[3 * 9 - 1] = 1e-6f;  // of degree 2
  model.dynamic_set.values().at(kShTime, 1)[48 + 47] = 1;
  const ModelHistograms histograms = histograms_of(model);
  EXPECT_EQ(histograms.static_degrees, (std::array<int64_t, 4>{0, 1, 2, 1}));
  EXPECT_EQ(histograms.dynamic_degrees, (std::array<int64_t, 4>{3, 0, 0, 1}));
  model.drawing.sh_degree = 1;
  model.drawing.sh_time_degree = 1;  // the last band and the last level are not active
  EXPECT_EQ(histograms_of(model).static_degrees, (std::array<int64_t, 4>{1, 3, 0, 0}));
  EXPECT_EQ(histograms_of(model).dynamic_degrees, (std::array<int64_t, 4>{4, 0, 0, 0}));
}

// Bugs put back: the last bin closed; extents of what is never drawn counted; the temporal filter
// left out; each seen to fail.
TEST(ModelHistograms, ExtentsAreOfWhatIsDrawn) {
  GaussianModel model = random_model(3, 6, 7, 1, SetForm::kVelocity);
  model.time_axis = {0, 8};
  const double extents[] = {1e-6, 0.003, 0.004, 1.5, 100, 0.3};
  const GaussianSpans<float> set = model.dynamic_set.values();
  for (int64_t n = 0; n < 6; ++n) {
    *set.at(kMeanTime, n) = 0.5f;
    *set.at(kOpacityLogit, n) = 2;
    *set.at(kLogScaleTime, n) = float(std::log(extents[n]));
  }
  *set.at(kMeanTime, 5) = 3;  // far behind the clip
  const ModelHistograms histograms = histograms_of(model);
  EXPECT_EQ(histograms.extents, (std::array<int64_t, 12>{2, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1}));
  EXPECT_EQ(histograms.never_drawn, 1);
  GaussianModel pairs = clone(model);
  pairs.dynamic_set = in_form(model.dynamic_set, SetForm::kPair);
  EXPECT_EQ(histograms_of(pairs).extents, histograms.extents);
  model.drawing.time_filter = 0.3 * 0.3;
  EXPECT_EQ(histograms_of(model).extents,
            (std::array<int64_t, 12>{0, 0, 0, 0, 0, 0, 0, 3, 0, 1, 0, 1}));
  const nlohmann::json json = to_json(histograms, model.time_axis)["temporal_extents"];
  ASSERT_EQ(json["edges_clip"].size() + 1, json["counts"].size());
  EXPECT_EQ(json["edges_clip"].front(), 1.0 / 256);
  EXPECT_EQ(json["edges_seconds"].front(), 8.0 / 256);
  EXPECT_EQ(json["edges_clip"].back(), 4);
}

}  // namespace
}  // namespace tessera::testing
