// The steps of events and the learning rates against the numbers of the method, and the order in
// which frames are drawn. Source: method A.3, A.4, D.5, D.6.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "recon4d/training/batch_sampler.h"
#include "recon4d/training/schedule.h"

namespace tessera {
namespace {

constexpr double kExtent = 2.5;

/// Steps before the end at which the event happens.
template <class Event>
std::vector<int64_t> steps_of(const TrainOptions& options, Event&& event) {
  const Schedule schedule(options, kExtent);
  std::vector<int64_t> steps;
  for (int64_t i = 0; i < options.iterations; ++i)
    if (event(schedule, i)) steps.push_back(i);
  return steps;
}
std::vector<int64_t> every(int64_t interval, int64_t first, int64_t last) {
  std::vector<int64_t> steps;
  for (int64_t i = first; i <= last; i += interval) steps.push_back(i);
  return steps;
}
const auto densifies = [](const Schedule& s, int64_t i) { return s.densify(i); };
const auto reorders = [](const Schedule& s, int64_t i) { return s.reorder(i); };
const auto prunes = [](const Schedule& s, int64_t i) { return s.prune_unseen(i); };
const auto resets = [](const Schedule& s, int64_t i) { return s.reset_opacity(i); };

TEST(TrainSchedule, EventsOfTheReference) {
  TrainOptions options;
  options.opacity_reset_interval = 3000;
  EXPECT_EQ(steps_of(options, densifies), every(100, 600, 14900));
  EXPECT_EQ(steps_of(options, reorders), (std::vector<int64_t>{0, 5000, 10000, 15000}));
  EXPECT_EQ(steps_of(options, resets), (std::vector<int64_t>{3000, 6000, 9000, 12000}));
  const auto large = [](const Schedule& s, int64_t i) { return s.prunes_large(i); };
  EXPECT_EQ(steps_of(options, large).front(), 3001);
  const auto gathers = [](const Schedule& s, int64_t i) { return s.gathers_statistics(i); };
  EXPECT_EQ(steps_of(options, gathers).back(), 14899);

  const Schedule schedule(options, kExtent);
  const int64_t steps[] = {0, 999, 1000, 1999, 2000, 3000, 29999};
  const int degrees[] = {0, 0, 1, 1, 2, 3, 3};
  for (size_t k = 0; k < std::size(steps); ++k)
    EXPECT_EQ(schedule.sh_degree(steps[k]), degrees[k]) << steps[k];
}

// Bug put back: a linear share; seen to fail.
TEST(TrainSchedule, SharesOfGrowthFollowTheSquareRootAndEndAtTheLimit) {
  TrainOptions options;
  options.iterations = 6500;  // controls at 132, 165 … 3234: 95
  options.densify_until = 15000;
  options.densify_interval = 33;
  const Schedule schedule(options, kExtent);
  const std::vector<int64_t> controls = steps_of(options, densifies);
  ASSERT_EQ(controls, every(33, 132, 3234));
  double count = 1000;
  for (size_t k = 0; k < controls.size(); ++k) {
    count += schedule.growth_share(controls[k]) * (9000 - count);
    EXPECT_NEAR(count, 1000 + 8000 * std::sqrt(double(k + 1) / double(controls.size())), 1e-6);
  }
  count = 6000;  // of a set that decisions have made smaller half-way
  for (size_t k = 50; k < controls.size(); ++k)
    count += schedule.growth_share(controls[k]) * (9000 - count);
  EXPECT_NEAR(count, 9000, 1e-6);
}

// Bugs put back, each seen to fail: pruning right after a reset; pruning without a least weight.
TEST(TrainSchedule, UnseenGaussiansAreNotPrunedUntilOpacitiesHaveRecovered) {
  TrainOptions options;
  options.iterations = 4000;
  options.schedule_iterations = 4000;
  EXPECT_TRUE(steps_of(options, prunes).empty());
  options.min_blending_weight = 0.05;
  EXPECT_EQ(steps_of(options, prunes), every(500, 1000, 3500));
  options.unseen_interval = 250;
  options.opacity_reset_interval = 1500;
  EXPECT_EQ(steps_of(options, prunes), (std::vector<int64_t>{750, 1000, 1250, 1500, 2000, 2250,
                                                             2500, 2750, 3000, 3500, 3750}));
}

// Bug put back: no extra reset; seen to fail.
// Bugs put back, each seen to fail: not at the start; on to the last step.
TEST(TrainSchedule, TheFilterIsMeasuredAfterDensityControlAndOnFromItsEnd) {
  TrainOptions options;
  const auto measures = [](const Schedule& s, int64_t i) { return s.measure_filter(i); };
  EXPECT_TRUE(steps_of(options, measures).empty());
  for (const Filter3d filter : {Filter3d::kMip, Filter3d::kClamp}) {
    options.filter_3d = filter;
    std::vector<int64_t> expected = every(100, 600, 29900);
    expected.insert(expected.begin(), 0);
    EXPECT_EQ(steps_of(options, measures), expected);
  }
  options.densify_until = 0;
  EXPECT_EQ(steps_of(options, measures), every(100, 0, 29900));
  options.iterations = options.schedule_iterations = 30050;
  EXPECT_EQ(steps_of(options, measures), every(100, 0, 29900));
}

TEST(TrainSchedule, ABrightBackgroundIsClearedOnceMore) {
  TrainOptions options;
  options.opacity_reset_interval = 3000;
  options.background = "white";
  EXPECT_EQ(steps_of(options, resets), (std::vector<int64_t>{500, 3000, 6000, 9000, 12000}));
  options.opacity_reset_interval = 0;
  EXPECT_TRUE(steps_of(options, resets).empty());
}

TEST(TrainSchedule, NothingHappensWhenOff) {
  TrainOptions options;
  options.reorder_interval = 0;
  options.densify_until = 0;
  options.sh_degree = 1;
  options.opacity_reset_interval = 3000;
  EXPECT_TRUE(steps_of(options, reorders).empty());
  EXPECT_TRUE(steps_of(options, densifies).empty());
  EXPECT_TRUE(steps_of(options, resets).empty()) << "resets end with density control";
  EXPECT_FALSE(Schedule(options, kExtent).gathers_statistics(0));
  EXPECT_EQ(Schedule(options, kExtent).sh_degree(29999), 1);
}

// Bug put back: re-ordering stops after three intervals of any length; seen to fail.
TEST(TrainSchedule, ReordersAsLongAsTheSetGrows) {
  TrainOptions options;
  options.reorder_interval = 1000;
  EXPECT_EQ(steps_of(options, reorders), every(1000, 0, 15000));
  options.reorder_interval = 20000;
  EXPECT_EQ(steps_of(options, reorders), (std::vector<int64_t>{0, 20000}));
  options.densify_until = 0;
  options.reorder_interval = 5000;
  EXPECT_EQ(steps_of(options, reorders), (std::vector<int64_t>{0}));
}

TEST(TrainSchedule, StepCountsScaleWithTheLength) {
  TrainOptions options;
  options.iterations = 3000;  // a tenth
  options.opacity_reset_interval = 3000;
  EXPECT_EQ(steps_of(options, densifies), every(100, 100, 1400));  // 60 to 1490, not scaled: 100
  EXPECT_EQ(steps_of(options, reorders), (std::vector<int64_t>{0, 500, 1000, 1500}));
  EXPECT_EQ(steps_of(options, resets), (std::vector<int64_t>{300, 600, 900, 1200}));
  EXPECT_FALSE(Schedule(options, kExtent).prunes_large(300));
  EXPECT_TRUE(Schedule(options, kExtent).prunes_large(301));
  EXPECT_EQ(Schedule(options, kExtent).sh_degree(99), 0);
  EXPECT_EQ(Schedule(options, kExtent).sh_degree(100), 1);
  options.iterations = 60000;  // twice
  EXPECT_EQ(steps_of(options, densifies), every(100, 1200, 29800));
  EXPECT_EQ(steps_of(options, reorders), every(10000, 0, 30000));
}

/// η of a group at step i: step_size · (1 − β1^t).
double rate(const AdamScalars<float>& scalars, int64_t i) {
  return double(scalars.step_size) * (1 - std::pow(0.9, double(i + 1)));
}

TEST(TrainSchedule, LearningRatesOfTheMethod) {
  const TrainOptions options;
  const Schedule schedule(options, kExtent);
  for (int64_t i : {int64_t{0}, int64_t{14999}, int64_t{29999}}) {
    const AdamGroups<float> adam = schedule.adam(i, SetForm::kPair);
    const double u = double(i + 1) / 30000;
    const double mean = kExtent * std::exp((1 - u) * std::log(1.6e-4) + u * std::log(1.6e-6));
    const auto expect_rate = [&](const AdamScalars<float>& scalars, double expected) {
      EXPECT_NEAR(rate(scalars, i), expected, 1e-6 * expected) << "step " << i;
      EXPECT_FLOAT_EQ(scalars.beta1, 0.9f);
      EXPECT_FLOAT_EQ(scalars.beta2, 0.999f);
      EXPECT_FLOAT_EQ(scalars.epsilon, 1e-15f);
      EXPECT_FLOAT_EQ(scalars.v_scale, float(1 / std::sqrt(1 - std::pow(0.999, double(i + 1)))));
    };
    expect_rate(adam.group[kMean], mean);
    expect_rate(adam.group[kMeanTime], 1.6e-4 * kExtent);  // constant  [method 0.16]
    expect_rate(adam.group[kLogScale], 5e-3);
    expect_rate(adam.group[kLogScaleTime], 5e-3);
    expect_rate(adam.group[kRotation], 1e-3);
    expect_rate(adam.group[kRotationRight], 1e-3);
    expect_rate(adam.group[kOpacityLogit], 0.05);
    expect_rate(adam.group[kSh], 2.5e-3);
    expect_rate(adam.sh_rest, 1.25e-4);
    const AdamGroups<float> drifting = schedule.adam(i, SetForm::kVelocity);
    expect_rate(drifting.group[kVelocity], 5e-4 / 1.6e-4 * mean);  // decays as the means do
    EXPECT_EQ(drifting.group[kLogScaleTime].step_size, adam.group[kLogScaleTime].step_size);
    const AdamGroups<float> still = schedule.adam(i, SetForm::kStatic);
    EXPECT_EQ(still.group[kMean].step_size, adam.group[kMean].step_size);
    EXPECT_NEAR(schedule.exposure_rate(i), 0.01 * std::pow(0.01, u), 1e-15);
  }
  EXPECT_NEAR(rate(schedule.adam(29999, SetForm::kStatic).group[kMean], 29999), 1.6e-6 * kExtent,
              1e-11);
  EXPECT_NEAR(rate(schedule.adam(14999, SetForm::kStatic).group[kMean], 14999), 1.6e-5 * kExtent,
              1e-10);
}

// Bug put back: it decays as the means do; seen to fail.
TEST(TrainSchedule, TemporalMeansKeepTheirRate) {
  const TrainOptions options;
  const auto rate = [&](int64_t i) {  // the bias of the moments vanishes at the end
    const AdamScalars<float> kept = adam_scalars<float>(1, i + 1);
    const AdamGroups<float> groups = Schedule(options, kExtent).adam(i, SetForm::kVelocity);
    return groups.group[kMeanTime].step_size / kept.step_size;
  };
  EXPECT_FLOAT_EQ(rate(0), 1.6e-4 * kExtent);
  EXPECT_FLOAT_EQ(rate(29999), 1.6e-4 * kExtent);
}

// Known by hand: between the ends the logarithm is linear. Bug put back: a linear decay; seen to
// fail.
TEST(TrainSchedule, MeansDecayLogLinearly) {
  const Schedule schedule({}, 1);
  for (const auto& [step, rate] : {std::pair{0, 1.6e-4},
                                   {3000, 1.00952e-4},
                                   {7500, 5.05964e-5},
                                   {14999, 1.6e-5},
                                   {22500, 5.05964e-6}})
    EXPECT_NEAR(schedule.mean_rate(step), rate, 2e-3 * rate) << step;
}

TEST(TrainSchedule, ARateOfZeroIsZero) {
  TrainOptions options;
  options.lr_mean = options.lr_mean_final = 0;
  EXPECT_EQ(Schedule(options, kExtent).adam(100, SetForm::kStatic).group[kMean].step_size, 0);
}

// Bug put back: indices drawn with replacement; seen to fail.
TEST(BatchSampler, EachPermutationCoversAll) {
  for (int64_t count : {1, 2, 7, 64})
    for (int64_t batch : {1, 3, 4, 10}) {
      BatchSampler sampler(count, 3);
      std::vector<int64_t> drawn;
      while (int64_t(drawn.size()) < 6 * count) {
        const std::vector<int64_t> next = sampler.next(batch);
        ASSERT_EQ(int64_t(next.size()), batch);
        drawn.insert(drawn.end(), next.begin(), next.end());
      }
      BatchSampler singly(count, 3);  // batches are consecutive pieces of the same sequence
      for (int64_t index : drawn) EXPECT_EQ(singly.next(1), std::vector<int64_t>{index});
      for (int64_t epoch = 0; epoch < 6; ++epoch) {
        const auto begin = drawn.begin() + epoch * count;
        std::vector<int64_t> seen(begin, begin + count);
        std::sort(seen.begin(), seen.end());
        for (int64_t i = 0; i < count; ++i) EXPECT_EQ(seen[size_t(i)], i);
      }
    }
}

TEST(BatchSampler, PermutationsAndSeedsDiffer) {
  BatchSampler a(20, 1);
  BatchSampler b(20, 2);
  const std::vector<int64_t> first = a.next(20);
  EXPECT_NE(first, a.next(20)) << "another permutation in the next epoch";
  EXPECT_NE(first, b.next(20)) << "another permutation for another seed";
  EXPECT_FALSE(std::is_sorted(first.begin(), first.end()));
}

TEST(BatchSampler, EveryFrameComesFirstEquallyOften) {
  constexpr int kDraws = 8000, kCount = 8;
  std::vector<int> first(kCount, 0);
  for (uint64_t seed = 0; seed < kDraws; ++seed)
    ++first[size_t(BatchSampler(kCount, seed).next(1)[0])];
  for (int n : first) EXPECT_NEAR(n, kDraws / kCount, 5 * std::sqrt(kDraws / kCount));
}

TEST(BatchSampler, RestoreContinuesExactly) {
  for (int64_t stop : {0, 1, 6, 7, 8, 13, 14, 30}) {  // 7 frames: also at the end of an epoch
    BatchSampler whole(7, 5);
    BatchSampler rest(7, 5);
    whole.next(stop);
    rest.restore(whole.epoch(), whole.position());
    EXPECT_EQ(rest.next(20), whole.next(20)) << stop;
    EXPECT_EQ(rest.epoch(), whole.epoch());
    EXPECT_EQ(rest.position(), whole.position());
  }
  BatchSampler sampler(7, 5);
  EXPECT_THROW(sampler.restore(0, 8), std::logic_error);
  EXPECT_THROW(BatchSampler(0, 5), std::logic_error);
}

}  // namespace
}  // namespace tessera
