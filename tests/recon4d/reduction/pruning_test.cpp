// The order in which Gaussians are pruned, exact counts of the remaining ones, and the knee of
// known curves. The cost of a removal is tested in contributions_test.cpp. Source: failure mode
// C13.
#include "recon4d/reduction/pruning.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "recon4d/model/element_edits.h"
#include "tests/recon4d/model/plain_gaussians.h"

namespace tessera::testing {
namespace {

/// Contributions that state of every Gaussian what its removal adds; all have light.
Contributions made_worth(const std::vector<float>& fixed, const std::vector<float>& moving = {}) {
  Contributions contributions;
  contributions.squared_error = 1;
  contributions.samples = 3000;
  for (int k = 0; k < 2; ++k) {
    const std::vector<float>& removal = k == 0 ? fixed : moving;
    contributions.sets[k].resize(int64_t(removal.size()));
    contributions.sets[k].removal2 = removal;
    contributions.sets[k].weight.assign(removal.size(), 1.0f);
  }
  return contributions;
}

GaussianModel made_model(const Contributions& contributions, int degree = 0) {
  GaussianModel model = empty_model(SetForm::kPair, degree);
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = k == 0 ? model.static_set : model.dynamic_set;
    set = plain_set(set, std::vector<Plain>(contributions.sets[k].weight.size()));
  }
  return model;
}

std::vector<Removal> made_order(const Contributions& contributions) {
  return removal_order(made_model(contributions), contributions);
}

// Bug put back: by error alone (a dynamic one frees more bytes); seen to fail.
TEST(Pruning, TheCheapestByteIsRemovedFirst) {
  const ByteRates rates;
  EXPECT_GT(rates.bytes_of(true, 0), rates.bytes_of(false, 0));
  EXPECT_NEAR(rates.bytes_of(false, 3) - rates.bytes_of(false, 0), 45 * rates.band, 1e-12);
  const Contributions contributions = made_worth({5, 1, 3}, {1.5f, 9});
  const std::vector<Removal> order = made_order(contributions);
  std::vector<float> errors;
  for (size_t i = 0; i < order.size(); ++i) {
    errors.push_back(float(order[i].error));
    EXPECT_EQ(errors.back(), contributions.sets[order[i].set].removal2[size_t(order[i].element)]);
    EXPECT_EQ(order[i].bytes, rates.bytes_of(order[i].set == 1, 0));
    if (i > 0) {
      EXPECT_LE(order[i - 1].error_per_byte(), order[i].error_per_byte());
    }
  }
  // 1/12.5, 1.5/20, 3/12.5, 5/12.5, 9/20
  EXPECT_EQ(errors, (std::vector<float>{1.5f, 1, 3, 5, 9}));
}

// Bug put back: all pixels count alike; seen to fail.
TEST(Pruning, WhatIsSeenInMovingPixelsCountsTwice) {
  Contributions contributions = made_worth({3, 3, 3, 3});
  contributions.sets[0].weight = {2, 2, 2, 0};
  contributions.sets[0].moving = {2, 0, 1, 0};
  std::vector<int64_t> elements;
  std::vector<double> errors;
  for (const Removal& removal : made_order(contributions)) {
    elements.push_back(removal.element);
    errors.push_back(removal.error);
  }
  EXPECT_EQ(elements, (std::vector<int64_t>{3, 1, 2, 0}));
  EXPECT_EQ(errors, (std::vector<double>{3, 3, 4.5, 6}));
}

// Bug put back: by price alone; seen to fail.
TEST(Pruning, EqualsGoInTheOrderOfElementsAndWhatHasNoLightFirst) {
  Contributions contributions = made_worth({2, 2, 0, 2, 0});
  contributions.sets[0].weight[4] = 0;
  std::vector<int64_t> elements;
  for (const Removal& removal : made_order(contributions)) elements.push_back(removal.element);
  EXPECT_EQ(elements, (std::vector<int64_t>{4, 2, 0, 1, 3}));
}

/// Removal errors of kSeen Gaussians behind those of kUnseen that no drawn frame shows.
constexpr int kUnseen = 40, kSeen = 200;
Contributions partly_seen(double share) {
  std::vector<float> removal(kUnseen, 0.0f);
  for (int n = 0; n < kSeen; ++n) removal.push_back(n < 120 ? 1e-6f : 0.01f * float(n));
  Contributions contributions = made_worth(removal);
  std::fill_n(contributions.sets[0].weight.begin(), kUnseen, 0.0f);
  contributions.share = share;
  return contributions;
}

// A pass over a part of the frames measures nothing of Gaussians that none of them shows: with one
// camera, those that are visible only between two of its frames. Bug put back: unseen ones first
// whatever was drawn; seen to fail.
TEST(Pruning, WhatAPartOfTheFramesDidNotShowStays) {
  const std::vector<Removal> order = made_order(partly_seen(0.5));
  EXPECT_EQ(seen_count(order), kSeen);
  const StateEdit cut = cut_to(order, 80);
  std::vector<int64_t> expected(kSeen - 80);
  std::iota(expected.begin(), expected.end(), int64_t{kUnseen});
  EXPECT_EQ(cut.dropped[0], expected);
  EXPECT_TRUE(cut_to(order, kSeen + 1).dropped[0].empty());
  EXPECT_EQ(cut_to(made_order(partly_seen(1)), kSeen).dropped[0].size(), size_t(kUnseen))
      << "no frame shows them";
}

// Most of what a part of the frames does not show is of no use to the others, either: it must not
// take the place of what they do show.
// Bug put back: unseen ones counted among those that are left; seen to fail.
TEST(Pruning, TheKneeIsThatOfWhatWasSeen) {
  for (const double share : {0.5, 1.0}) {
    const Contributions contributions = partly_seen(share);
    const int64_t knee = knee_count(made_order(contributions), contributions);
    EXPECT_GE(knee, kSeen - 120) << share;
    EXPECT_LE(knee, kSeen - 119) << share;
  }
}

// C13. Bug put back: one more kept; seen to fail.
TEST(Pruning, LeavesExactlySoMany) {
  const Contributions contributions = made_worth({5, 1, 3, 2, 8, 0, 0}, {1, 9, 4, 0});
  const GaussianModel model = made_model(contributions);
  const std::vector<Removal> order = removal_order(model, contributions);
  for (int64_t asked : {-5, -1, 0, 1, 2, 5, 10, 11, 12, 1000}) {
    const KeptElements elements = kept_elements(model, order, asked);
    const int64_t left = int64_t(elements.set_elements[0].size() + elements.set_elements[1].size());
    EXPECT_EQ(left, std::clamp<int64_t>(asked, 0, 11)) << asked;
    std::set<std::pair<int, int64_t>> expected;
    for (int64_t i = 11 - left; i < 11; ++i)
      expected.emplace(order[size_t(i)].set, order[size_t(i)].element);
    for (int k = 0; k < 2; ++k) {
      EXPECT_TRUE(std::is_sorted(elements.set_elements[k].begin(), elements.set_elements[k].end()));
      for (const int64_t element : elements.set_elements[k])
        EXPECT_EQ(expected.erase({k, element}), 1u);
    }
    EXPECT_TRUE(expected.empty());
    const StateEdit cut = cut_to(order, asked);
    for (int k = 0; k < 2; ++k)
      EXPECT_EQ(elements_but(int64_t(contributions.sets[k].weight.size()), cut.dropped[k]),
                elements.set_elements[k]);
    const GaussianModel thinned = with_elements(model, elements);
    EXPECT_EQ(thinned.count(), left);
    EXPECT_EQ(thinned.static_set.count(), int64_t(elements.set_elements[0].size()));
  }
  EXPECT_THROW(kept_elements(model, made_order(made_worth({1, 2})), 1), std::logic_error);
}

// Bug put back: the point after the last of the most; seen to fail.
TEST(Pruning, TheKneeKeepsTheHalfThatDoesSomething) {
  for (const float each : {1e-4f, 0.01f, 1.0f}) {
    std::vector<float> removal(200, 0.0f);
    for (size_t i = 0; i < removal.size(); i += 2) removal[i] = each;
    const Contributions contributions = made_worth(removal);
    const std::vector<Removal> order = made_order(contributions);
    const int64_t knee = knee_count(order, contributions);
    EXPECT_EQ(knee, 100) << each;
    const KeptElements elements = kept_elements(made_model(contributions), order, knee);
    for (const int64_t element : elements.set_elements[0]) EXPECT_EQ(element % 2, 0);
  }
}

// The k-th of N costs e^(−λ k/N): the curve bends once.
TEST(Pruning, TheKneeLiesFarthestAboveTheLine) {
  const int64_t count = 500;
  std::vector<float> removal;
  for (int64_t n = 0; n < count; ++n) removal.push_back(float(std::exp(-0.03 * double(n))));
  const Contributions contributions = made_worth(removal);
  const std::vector<Removal> order = made_order(contributions);
  const int64_t knee = knee_count(order, contributions);
  const auto point = [&](int64_t left) {
    double error = 0;
    for (int64_t i = 0; i < count - left; ++i) error += order[size_t(i)].error;
    return std::pair{std::log(double(left)), contributions.psnr_after(error)};
  };
  const int64_t least = (count + 31) / 32;
  const auto [x0, y0] = point(least);
  const auto [x1, y1] = point(count);
  const auto above = [&, x0 = x0, y0 = y0, x1 = x1, y1 = y1](int64_t left) {
    const auto [x, y] = point(left);
    return (y - y0) / (y1 - y0) - (x - x0) / (x1 - x0);
  };
  for (int64_t left = least; left <= count; ++left)
    EXPECT_LE(above(left), above(knee) + 1e-12) << left;
  EXPECT_GT(knee, least);
  EXPECT_LT(knee, count / 2);
}

// Bug put back: no least share; seen to fail.
TEST(Pruning, TheKneeOfWhatDoesNothingIsTheLeastShare) {
  const auto knee = [](const Contributions& contributions, double share) {
    return knee_count(made_order(contributions), contributions, share);
  };
  const Contributions idle = made_worth(std::vector<float>(64, 0.0f));
  EXPECT_EQ(knee(idle, 1.0 / 32), 2);
  EXPECT_EQ(knee(idle, 1.0 / 4), 16);
  EXPECT_EQ(knee(idle, 0), 1) << "never none";
  EXPECT_EQ(knee(made_worth({}), 1.0 / 32), 0);
  EXPECT_EQ(knee(made_worth({3}), 1.0 / 32), 1);
  EXPECT_GE(knee(made_worth({3, 4}), 1.0 / 32), 1);
}

// Bug put back: the price of the first that stays; seen to fail.
TEST(Pruning, ThePriceOfAByteIsThatOfTheLastRemoval) {
  const std::vector<Removal> order = made_order(made_worth({1, 2, 4}));
  const double bytes = ByteRates{}.bytes_of(false, 0);
  EXPECT_EQ(error_per_byte_at(order, 3), 0);
  EXPECT_EQ(error_per_byte_at(order, 9), 0);
  EXPECT_EQ(error_per_byte_at(order, 2), 1 / bytes);
  EXPECT_EQ(error_per_byte_at(order, 1), 2 / bytes);
  EXPECT_EQ(error_per_byte_at(order, 0), 4 / bytes);
}

}  // namespace
}  // namespace tessera::testing
