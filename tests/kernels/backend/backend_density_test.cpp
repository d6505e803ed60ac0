// The stages of density control and ordering of every backend against those of the CPU, which are
// tested in tests/recon4d/density/train_density_test.cpp and locality_test.cpp.
#include <numeric>

#include "kernels/cpu_backend.h"
#include "tests/support/compare.h"
#include "tests/support/crowd.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {
namespace {

class BackendDensity : public BesideCpu {};
TESSERA_ON_EVERY_BACKEND(BackendDensity);

struct Statistic {
  std::vector<float> sum, count;
};

Statistic statistic(uint64_t seed, bool ties, int64_t gaussians = kCrowd) {
  Random random(seed);
  Statistic out;
  for (int64_t n = 0; n < gaussians; ++n) {
    out.count.push_back(float(random.below(4)));
    const double mean = ties ? 1e-4 * random.below(6) : random.uniform(0, 5e-4);
    out.sum.push_back(float(mean) * out.count.back());
  }
  return out;
}

struct Selected {
  std::vector<int64_t> index;
  int64_t survivors, clones, parents, pruned;
  bool operator==(const Selected&) const = default;
  /// Those that are cloned or split.
  std::vector<int64_t> grown() const {
    return {index.begin() + survivors, index.begin() + survivors + clones + parents};
  }
};

Selected select(Backend& on, const TestGaussians<float>& set, const Statistic& s,
                const DensityRule& rule) {
  Memory& memory = on.memory();
  const StoredGaussians<float> gaussians(set, memory);
  const Buffer<float> sum = stored(s.sum, memory), count = stored(s.count, memory);
  DensityElements elements(memory);
  on.select_elements(gaussians.view(), {sum.span(), count.span()}, rule, elements);
  return {fetched(elements.index, memory), elements.survivors, elements.clones, elements.parents,
          elements.pruned};
}

TEST_P(BackendDensity, ElementsAreTheCpus) {
  // Bugs put back, seen to fail: the dead make no room; clones in another order.
  for (const SetForm form : kForms)
    for (const bool ties : {false, true})
      for (const double largest : {0.0, 0.2})
        for (const int64_t room :
             {int64_t{-1}, int64_t{0}, int64_t{1}, int64_t{333}, int64_t{100000}}) {
          SCOPED_TRACE(std::string(form_name(form)) + " ties " + std::to_string(ties) + " room " +
                       std::to_string(room) + " largest " + std::to_string(largest));
          const TestGaussians<float> set = crowd(form, 81);
          const Statistic s = statistic(82, ties);
          const DensityRule rule{2e-4, 0.005, 0.05, largest, room};
          const Selected actual = select(backend(), set, s, rule);
          const Selected expected = select(cpu(), set, s, rule);
          EXPECT_EQ(actual.survivors, expected.survivors);
          EXPECT_EQ(actual.clones, expected.clones);
          EXPECT_EQ(actual.parents, expected.parents);
          EXPECT_EQ(actual.pruned, expected.pruned);
          EXPECT_EQ(actual.index, expected.index);
        }
}

TEST_P(BackendDensity, DrawnElementsAreTheCpus) {
  for (const SetForm form : kForms)
    for (const int64_t room : {int64_t{0}, int64_t{1}, int64_t{333}, int64_t{100000}}) {
      const TestGaussians<float> set = crowd(form, 81);
      const Statistic s = statistic(82, false);
      const DensityRule rule{.threshold = 1e-4,
                             .prune_opacity = 0.005,
                             .room = room,
                             .halves = true,
                             .drawn = true,
                             .seed = 89};
      const Selected drawn = select(backend(), set, s, rule);
      EXPECT_EQ(drawn, select(cpu(), set, s, rule)) << form_name(form) << " room " << room;
      EXPECT_EQ(drawn.clones, 0);
      DensityRule strongest = rule;
      strongest.drawn = false;
      if (room == 333) {
        EXPECT_NE(drawn.index, select(backend(), set, s, strongest).index);
      }
    }
}

TEST_P(BackendDensity, GrowthWeightsAreTheCpus) {
  // Bug put back: those below the threshold counted, too; seen to fail.
  for (const SetForm form : kForms)
    for (const int64_t count : {int64_t{0}, int64_t{1}, kCrowd}) {
      const TestGaussians<float> set = crowd(form, 81, count);
      const Statistic s = statistic(82, false, count);
      const DensityRule rule{.threshold = 2e-4, .prune_opacity = 0.005};
      const auto weight = [&](Backend& on) {
        Memory& memory = on.memory();
        const StoredGaussians<float> gaussians(set, memory);
        const Buffer<float> sum = stored(s.sum, memory), seen = stored(s.count, memory);
        return on.growth_weight(gaussians.view(), {sum.span(), seen.span()}, rule);
      };
      double expected = 0;
      for (const int64_t n : select(cpu(), set, s, rule).grown())
        expected += double(s.sum[size_t(n)] / s.count[size_t(n)]);
      EXPECT_NEAR(weight(backend()), expected, 1e-9) << form_name(form) << " of " << count;
    }
}

TEST_P(BackendDensity, ElementsOfEmptyAndOfDyingSets) {
  const DensityRule rule{2e-4, 0.005, 0.05, 0, 10};
  for (const int64_t count : {0, 1, 70}) {
    TestGaussians<float> set = crowd(SetForm::kPair, 83, count);
    const Statistic s = statistic(84, false, count);
    EXPECT_EQ(select(backend(), set, s, rule), select(cpu(), set, s, rule));
    std::fill(set.group[kOpacityLogit].begin(), set.group[kOpacityLogit].end(), -9.0f);
    const Selected none = select(backend(), set, s, rule);
    EXPECT_TRUE(none.index.empty());
    EXPECT_EQ(none.pruned, count);
  }
}

TEST_P(BackendDensity, ChildrenAreTheCpus) {
  // Bugs put back, seen to fail: another seed; the first child left out.
  for (const SetForm form : kForms)
    for (const SplitRule& rule : {SplitRule{false, 7}, SplitRule{true, 0}}) {
      Random random(85);
      const TestGaussians<float> before =
          random_gaussians(form, kCrowd, 1, 0.1, random).as<float>();
      constexpr int64_t kFirst = 1234;
      const auto placed = [&](Backend& on) {
        StoredGaussians<float> set(before, on.memory());
        on.place_children(set.spans(), kFirst, rule);
        return set.fetch();
      };
      const TestGaussians<float> actual = placed(backend()), expected = placed(cpu());
      for (int g = 0; g < group_count(form); ++g) {
        const size_t first = size_t(kFirst * group_width(Group(g), 16, form));
        for (size_t i = 0; i < first; ++i)
          ASSERT_EQ(actual.group[g][i], before.group[g][i]) << group_name(Group(g), form);
        // offsets of up to 0.8 from logarithms and sines that are good to 1e-6
        for (size_t i = first; i < before.group[g].size(); ++i)
          ASSERT_NEAR(actual.group[g][i], expected.group[g][i], 3e-6) << group_name(Group(g), form);
      }
      EXPECT_NE(actual.group[kMean], before.group[kMean]);
    }
}

TEST_P(BackendDensity, OrderIsTheCpus) {
  // Bugs put back, seen to fail: time ignored; not stable.
  for (const SetForm form : kForms)
    for (const int64_t count : {int64_t{0}, int64_t{1}, kCrowd}) {
      TestGaussians<float> set = crowd(form, 86, count);
      for (int64_t n = 1; n < count; n += 3)  // equal keys: stable
        std::copy_n(set.at(kMean, n - 1), 3, set.at(kMean, n));
      const auto order = [&](Backend& on) {
        const StoredGaussians<float> gaussians(set, on.memory());
        Buffer<int64_t> out(on.memory());
        on.locality_order(gaussians.view(), out);
        return fetched(out, on.memory());
      };
      const std::vector<int64_t> actual = order(backend()), expected = order(cpu());
      EXPECT_EQ(actual, expected) << form_name(form) << " of " << count;
    }
}

TEST_P(BackendDensity, GatheredElementsAreThoseOfTheIndex) {
  // Bug put back: one element too many inherited; seen to fail.
  Random random(87);
  for (const int width : {1, 3, 4, 48}) {
    std::vector<float> from(size_t(kCrowd * width));
    for (float& x : from) x = float(random.uniform(-1, 1));
    std::vector<int64_t> index;
    for (int64_t i = 0; i < 2 * kCrowd; ++i) index.push_back(random.below(int(kCrowd)));
    for (size_t i = 0; i < index.size(); i += 11) index[i] = -1;
    for (const int64_t inherited : {int64_t{0}, kCrowd + 3, 2 * kCrowd}) {
      const Buffer<float> source = stored(from, memory());
      const Buffer<int64_t> elements = stored(index, memory());
      Buffer<float> to = stored(std::vector<float>(index.size() * size_t(width), -7), memory());
      backend().gather_elements(source.span(), elements.span(), width, inherited, to.span());
      const std::vector<float> actual = fetched(to, memory());
      for (size_t i = 0; i < actual.size(); ++i) {
        const size_t element = i / size_t(width), column = i % size_t(width);
        const bool zero = index[element] < 0 || int64_t(element) >= inherited;
        ASSERT_EQ(actual[i], zero ? 0.0f : from[size_t(index[element]) * size_t(width) + column]);
      }
    }
  }
}

TEST_P(BackendDensity, RunningMeans) {
  Random random(90);
  std::vector<float> sum(kCrowd, 0.0f);
  Buffer<float> mean = stored(std::vector<float>(kCrowd, 7.0f), memory());
  for (int n = 1; n <= 4; ++n) {
    std::vector<float> values(kCrowd);
    for (size_t i = 0; i < values.size(); ++i) sum[i] += values[i] = float(random.uniform(-8, 8));
    const Buffer<float> added = stored(values, memory());
    backend().add_to_mean(added.span(), 1.0f / float(n), mean.span());
  }
  const std::vector<float> actual = fetched(mean, memory());
  for (size_t i = 0; i < sum.size(); ++i) ASSERT_NEAR(actual[i], sum[i] / 4, 4e-6);
  backend().add_to_mean({}, 1, {});
}

TEST_P(BackendDensity, LimitsAndZeros) {
  // Bugs put back, seen to fail: the larger of both; the last one not zeroed.
  Random random(88);
  std::vector<float> values(kCrowd);
  for (float& x : values) x = float(random.uniform(-8, 8));
  Buffer<float> buffer = stored(values, memory());
  // the last ones are beyond the span
  backend().limit_values({buffer.data(), kCrowd - 3}, -4.6f);
  std::vector<float> actual = fetched(buffer, memory());
  for (size_t i = 0; i < values.size(); ++i)
    ASSERT_EQ(actual[i], i + 3 < values.size() ? std::min(values[i], -4.6f) : values[i]);
  backend().fill_zero({buffer.data() + 5, kCrowd - 9});
  const std::vector<float> zeroed = fetched(buffer, memory());
  for (size_t i = 0; i < values.size(); ++i)
    ASSERT_EQ(zeroed[i], i >= 5 && i + 4 < values.size() ? 0.0f : actual[i]) << i;
  backend().fill_zero({});
  backend().limit_values({}, 0);
}

}  // namespace
}  // namespace tessera::testing
