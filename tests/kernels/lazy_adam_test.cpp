// What: Adam steps without a gradient in closed form against the same steps one by one, over single
// gaps and whole runs, in double and in float.
// Not: Adam's equation (scalar_test.cpp).
#include "kernels/math/lazy_adam.h"
#include "kernels/lazy_schedule.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

constexpr double kRate = 2.5e-3;

template <class Real>
struct Scalar {
  Real value, m, v;
};

/// Steps `from` … `to` without a gradient, one by one.
template <class Real>
void idle_steps(Scalar<Real>& s, int64_t from, int64_t to) {
  for (int64_t t = from; t <= to; ++t)
    adam_step(adam_scalars<Real>(kRate, t), Real(0), s.value, s.m, s.v);
}

template <class Real>
void catch_up(Scalar<Real>& s, const std::vector<double>& table, int64_t last, int64_t to) {
  lazy_catch_up(lazy_gap<Real>(table.data(), last, to), Real(kRate), s.value, s.m, s.v);
}

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0, 1));
}

TEST(LazyAdam, TableIsTheSumOfTheStepsWeights) {
  // Bugs put back, each seen to fail: c(t) for c(t+1) in the recurrence; ρ = β1; a tail of 60
  // steps.
  const int64_t steps = 2000;
  const std::vector<double> table = lazy_adam_table(steps);
  ASSERT_EQ(table.size(), size_t(steps + 1));
  const double rho = 0.9 / std::sqrt(0.999);
  for (const int64_t t0 : {1, 2, 7, 100, 1500, 1999})
    for (const int64_t k : {1, 2, 3, 30, 500}) {
      if (t0 + k > steps) continue;
      double sum = 0;
      for (int64_t s = 1; s <= k; ++s)
        sum += std::sqrt(1 - std::pow(0.999, double(t0 + s))) /
               (1 - std::pow(0.9, double(t0 + s))) * std::pow(rho, double(s));
      EXPECT_NEAR(lazy_gap<double>(table.data(), t0, t0 + k).w, sum, 1e-12 * sum) << t0 << ' ' << k;
    }
  // The table does not depend on where it ends.
  const std::vector<double> longer = lazy_adam_table(steps + 5000);
  for (size_t t = 0; t < table.size(); ++t) EXPECT_NEAR(table[t], longer[t], 1e-13) << t;
}

TEST(LazyAdam, GapIsTheStepsOneByOneUpToWhereEpsilonActs) {
  // Bugs put back, each seen to fail: table[last_step − 1]; ρ = β1; decay2 from β1;
  // ε without √(1−β2^t0).
  const std::vector<double> table = lazy_adam_table(20000);
  Random random(3);
  for (int i = 0; i < 400; ++i) {
    const int64_t t0 = 1 + int64_t(log_uniform(random, 1, 15000));
    const int64_t k = 1 + int64_t(log_uniform(random, 1, 1000));
    const double root = log_uniform(random, 1e-18, 1e-3);  // √v, down to far below ε
    Scalar<double> dense{0, random.uniform(-6, 6) * root, root * root}, lazy = dense;
    const double start = lazy.m;
    idle_steps(dense, t0 + 1, t0 + k);
    catch_up(lazy, table, t0, t0 + k);
    const double e = 1e-15 * std::sqrt(1 - std::pow(0.999, double(t0))) / root;
    const double bound = (0.00505 + 5 / double(t0)) * e / (1 + e) + 1e-11;
    EXPECT_NEAR(lazy.value, dense.value, bound * std::abs(dense.value)) << t0 << ' ' << k;
    EXPECT_NEAR(lazy.m, dense.m, 1e-12 * std::abs(start) + 1e-11 * std::abs(dense.m));
    EXPECT_NEAR(lazy.v / dense.v, 1, 1e-11);
  }
}

/// A Gaussian's life: dense and lazy in Real, dense in double, fed the same gradients.
template <class Real>
struct Life {
  Scalar<double> exact;
  Scalar<Real> dense, lazy;
  double path = 0;  // Σ |step| of `exact`
};

template <class Real>
Life<Real> live(const std::vector<double>& table, int64_t steps, Random& random) {
  const double visible = random.uniform(0.02, 0.3), size = log_uniform(random, 1e-10, 1e-4);
  const Real value = Real(random.uniform(-1, 1));
  Life<Real> r{{double(value), 0, 0}, {value, 0, 0}, {value, 0, 0}};
  int64_t last = 0;
  for (int64_t t = 1; t <= steps; ++t) {
    const bool seen = random.uniform(0, 1) < visible;
    const Real g = seen ? Real(size * random.uniform(-1, 1.5)) : Real(0);
    const double before = r.exact.value;
    adam_step(adam_scalars<double>(kRate, t), double(g), r.exact.value, r.exact.m, r.exact.v);
    adam_step(adam_scalars<Real>(kRate, t), g, r.dense.value, r.dense.m, r.dense.v);
    r.path += std::abs(r.exact.value - before);
    if (!seen) continue;
    catch_up(r.lazy, table, last, t - 1);
    adam_step(adam_scalars<Real>(kRate, t), g, r.lazy.value, r.lazy.m, r.lazy.v);
    last = t;
  }
  catch_up(r.lazy, table, last, steps);
  return r;
}

TEST(LazyAdam, RunsInDoubleAreTheDenseRuns) {
  // Bugs put back, each seen to fail: table[step − 1]; ρ^k one step short; the caller's catch-up
  // to t instead of t − 1.
  const int64_t steps = 5000;
  const std::vector<double> table = lazy_adam_table(steps);
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    const Life<double> r = live<double>(table, steps, random);
    EXPECT_LT(std::abs(r.lazy.value - r.exact.value), 1e-6 * r.path) << i;
    EXPECT_NEAR(r.lazy.m, r.exact.m, 1e-9 * std::sqrt(r.exact.v));
    EXPECT_NEAR(r.lazy.v / r.exact.v, 1, 1e-9);
  }
}

TEST(LazyAdam, RunsInFloatErrNoMoreThanDenseOnes) {
  // Bug put back: v decays by 0.999 instead of 0.999f, which the gain 1 − 0.999f does not
  // match: 2.3 times the error of the dense runs; seen to fail.
  const int64_t steps = 5000;
  const std::vector<double> table = lazy_adam_table(steps);
  Random random(7);
  double dense = 0, lazy = 0, worst_dense = 0, worst_lazy = 0;
  for (int i = 0; i < 200; ++i) {
    const Life<float> r = live<float>(table, steps, random);
    const double of_dense = std::abs(double(r.dense.value) - r.exact.value);
    const double of_lazy = std::abs(double(r.lazy.value) - r.exact.value);
    dense += of_dense * of_dense, lazy += of_lazy * of_lazy;
    worst_dense = std::max(worst_dense, of_dense), worst_lazy = std::max(worst_lazy, of_lazy);
    EXPECT_LT(of_lazy, 5e-6 * r.path + 1e-6) << i;
  }
  EXPECT_LT(std::sqrt(lazy), 1.5 * std::sqrt(dense));
  EXPECT_LT(worst_lazy, 1.5 * worst_dense + 1e-6);
}

TEST(LazyAdam, DecaysOfLongGapsAreThoseOfDoubleInFloat) {
  // Bug put back: exp2 of a float k·log₂β; seen to fail.
  const std::vector<double> table = lazy_adam_table(100001);
  for (const int64_t k : {1, 10, 300, 5000, 50000}) {
    const LazyGap<float> gap = lazy_gap<float>(table.data(), 1, 1 + k);
    EXPECT_NEAR(double(gap.decay2) / std::pow(double(0.999f), double(k)), 1, 1e-7) << k;
    if (k > 300) continue;
    EXPECT_NEAR(double(gap.decay1) / std::pow(double(0.9f), double(k)), 1, 1e-7) << k;
  }
  const LazyGap<float> longest = lazy_gap<float>(table.data(), 1, 100001);
  EXPECT_EQ(longest.decay1, 0.0f);
  EXPECT_LT(longest.decay2, 1e-42f);
  EXPECT_TRUE(std::isfinite(longest.w));
}

template <class Real>
void expect_no_gap_changes_nothing(const std::vector<double>& table) {
  Random random(9);
  for (const int64_t t : {1, 2, 50, 1000}) {
    const Real root = Real(log_uniform(random, 1e-12, 1e-3));
    const Scalar<Real> before{Real(random.uniform(-1, 1)), Real(3) * root, root * root};
    Scalar<Real> after = before;
    catch_up(after, table, t, t);
    EXPECT_EQ(after.value, before.value);
    EXPECT_EQ(after.m, before.m);
    EXPECT_EQ(after.v, before.v);
  }
}

TEST(LazyAdam, NoGapChangesNoBit) {
  // Bug put back: k counted from last_step − 1; seen to fail.
  const std::vector<double> table = lazy_adam_table(1000);
  expect_no_gap_changes_nothing<float>(table);
  expect_no_gap_changes_nothing<double>(table);
}

TEST(LazyAdam, WithoutMomentsNothingMoves) {
  // Bug put back: no case for last_step = 0 (0/0); seen to fail.
  const std::vector<double> table = lazy_adam_table(3000);
  for (const int64_t last : {0, 1, 2000})
    for (const int64_t to : {last, last + 1, int64_t(3000)}) {
      Scalar<float> s{0.7f, 0, 0};
      catch_up(s, table, last, to);
      EXPECT_EQ(s.value, 0.7f) << last << ' ' << to;
      EXPECT_EQ(s.m, 0.0f);
      EXPECT_EQ(s.v, 0.0f);
    }
}

TEST(LazyAdam, TwoGapsAreOne) {
  // Bug put back: v is not decayed; seen to fail.
  const std::vector<double> table = lazy_adam_table(4000);
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    const int64_t t0 = 1 + random.below(3000), t1 = t0 + random.below(300);
    const int64_t t2 = t1 + random.below(300);
    const double root = log_uniform(random, 1e-6, 1e-3);
    Scalar<double> one{0.25, random.uniform(-6, 6) * root, root * root}, two = one;
    Scalar<float> one_f{0.25f, float(one.m), float(one.v)}, two_f = one_f;
    catch_up(one, table, t0, t2);
    catch_up(two, table, t0, t1), catch_up(two, table, t1, t2);
    EXPECT_NEAR(two.value, one.value, 1e-10);  // ε: 0.505 % of 1e-15/√v of a step
    EXPECT_NEAR(two.m, one.m, 1e-13 * root);
    EXPECT_NEAR(two.v, one.v, 1e-13 * root * root);
    catch_up(one_f, table, t0, t2);
    catch_up(two_f, table, t0, t1), catch_up(two_f, table, t1, t2);
    EXPECT_NEAR(two_f.value, one_f.value, 1e-7);
    EXPECT_NEAR(two_f.m, one_f.m, 1e-6 * std::abs(double(one_f.m)) + 1e-37);
    EXPECT_NEAR(two_f.v, one_f.v, 1e-6 * double(one_f.v));
  }
}

}  // namespace
}  // namespace tessera::testing
