// What: SH coefficients that catch up when they are next seen against those that take every step,
// over 50 steps with random visibility. Source: method G.3; the table is made here from its sum.
// Not: which of both a trainer chooses.
#include "tests/support/backends.h"
#include "tests/support/compare.h"
#include "tests/support/optimised.h"

namespace tessera::testing {
namespace {

constexpr int kSteps = 50;
constexpr double kRate = 2.5e-3, kRateRest = kRate / 20;

/// T[s] = Σ_{t>s} r^{t−s}·√(1−β2^t)/(1−β1^t), r = β1/√β2: what is still to come at step s of a
/// value with m/√v = 1 and learning rate 1. Terms beyond 600 are below 1e-27.
std::vector<double> table_by_its_sum() {
  std::vector<double> table;
  for (int s = 0; s <= kSteps; ++s) {
    double sum = 0;
    for (int t = s + 1; t <= s + 600; ++t)
      sum += std::pow(0.9 / std::sqrt(0.999), t - s) * std::sqrt(1 - std::pow(0.999, t)) /
             (1 - std::pow(0.9, t));
    table.push_back(sum);
  }
  return table;
}

/// Gaussians all around, six narrow cameras that each see some of them.
TestScene<float> wide_scene() {
  Random random(51);
  TestScene<double> scene;
  scene.fixed = random_gaussians(Form::kStatic, 150, 3, 0.1, random);
  scene.moving = random_gaussians(Form::kPair, 150, 3, 0.1, random);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (double& c : set->group[kSh]) c *= 0.1;  // no channel is ever clamped
  for (int k = 0; k < 6; ++k)
    scene.views.push_back(
        {look_at({0.1, 0.2, 0}, {std::cos(k), 0.2, std::sin(k)}, 48, 33, 40), 0.1 + 0.15 * k});
  return scene.as<float>();
}

/// dL/d splat of step `step`: colours only, by Gaussian.
std::vector<SplatGradient<float>> colour_gradients(const std::vector<int64_t>& first_of, int step) {
  std::vector<SplatGradient<float>> out(size_t(first_of.back()));
  for (size_t n = 0; n + 1 < first_of.size(); ++n) {
    Random random(uint64_t(step) * 1000 + n);
    const auto d = random.array<3>(-1e-2, 1e-2);
    for (int64_t s = first_of[n]; s < first_of[n + 1]; ++s)
      out[size_t(s)].colour = Vec3<float>(float(d[0]), float(d[1]), float(d[2]));
  }
  return out;
}

/// What 50 steps with idle updates of one kind made.
struct ShRun {
  std::vector<std::vector<float>> colours;  // of each step's splats
  TestGaussians<float> value[2]{TestGaussians<float>(Form::kStatic),
                                TestGaussians<float>(Form::kPair)};
  TestGaussians<float> moment1[2]{TestGaussians<float>(Form::kStatic),
                                  TestGaussians<float>(Form::kPair)};
  TestGaussians<float> moment2[2]{TestGaussians<float>(Form::kStatic),
                                  TestGaussians<float>(Form::kPair)};
  std::vector<int32_t> last_step[2];
  double idle = 0;  // share of Gaussians that a step did not see
};

class ShTraining {
 public:
  ShTraining(const TestScene<float>& scene, Backend& backend, IdleUpdate idle)
      : scene_(scene),
        backend_(backend),
        memory_(backend.memory()),
        idle_(idle),
        state_(scene, memory_),
        table_(stored(table_by_its_sum(), memory_)) {
    for (size_t set = 0; set < 2; ++set) {
      for (StoredGaussians<float>* m : {&state_.moment1[set], &state_.moment2[set]})
        backend.fill_zero(m->spans().group[kSh]);
      last_step_[set] = stored(std::vector<int32_t>(size_t(scene.fixed.count), 0), memory_);
    }
  }

  ShRun run() {
    ShRun out;
    for (int step = 1; step <= kSteps; ++step) take(step, out);
    for (size_t set = 0; set < 2; ++set) {
      if (idle_ == IdleUpdate::kLazy) backend_.catch_up(lazy(set, kSteps));
      out.value[set] = state_.value[set].fetch();
      out.moment1[set] = state_.moment1[set].fetch();
      out.moment2[set] = state_.moment2[set].fetch();
      out.last_step[set] = fetched(last_step_[set], memory_);
    }
    return out;
  }

 private:
  LazySh<float> lazy(size_t set, int64_t done) {
    if (idle_ != IdleUpdate::kLazy) return {};
    return {last_step_[set].span(),
            table_.span(),
            state_.value[set].spans().group[kSh],
            state_.moment1[set].spans().group[kSh],
            state_.moment2[set].spans().group[kSh],
            done,
            float(kRate),
            float(kRateRest)};
  }

  void take(int step, ShRun& out) {
    const ViewBatch<float> batch =
        make_view_batch<float>({scene_.views[size_t(Random(uint64_t(step)).below(6))]});
    Splats<float> splats(memory_);
    ProjectBackwardArgs<float> args;
    for (size_t set = 0; set < 2; ++set) {
      args.forward.sets[set] = std::as_const(state_.value[set]).view();
      args.forward.lazy[set] = lazy(set, step - 1);
      SinkArgs<float>& sink = args.sinks[set];
      sink = state_.sink(set, step, true, idle_);
      for (AdamScalars<float>& group : sink.adam.group) group = adam_scalars<float>(0, step);
      sink.adam.group[kSh] = adam_scalars<float>(kRate, step);
      sink.adam.sh_rest = adam_scalars<float>(kRateRest, step);
      sink.lazy = lazy(set, step - 1);
    }
    args.forward.batch = &batch;
    backend_.project(args.forward, splats);
    const std::vector<int64_t> first_of = fetched(splats.first_of, memory_);
    Buffer<SplatGradient<float>> d_splats = stored(colour_gradients(first_of, step), memory_);
    args.splats = &splats, args.d_splats = d_splats.span();
    backend_.project_backward(args);
    out.colours.emplace_back();
    for (const Splat<float>& s : fetched(splats.splat, memory_))
      for (int c = 0; c < 3; ++c) out.colours.back().push_back(s.colour[c]);
    const double gaussians = double(first_of.size() - 1);
    out.idle += (gaussians - double(splats.count)) / gaussians / kSteps;
  }

  const TestScene<float>& scene_;
  Backend& backend_;
  Memory& memory_;
  IdleUpdate idle_;
  Optimised<float> state_;
  Buffer<double> table_;
  Buffer<int32_t> last_step_[2];
};

class BackendLazy : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendLazy);

TEST_P(BackendLazy, CatchingUpEqualsEveryStep) {
  // Bugs put back, each seen to fail: drawn without catching up; last_step not set; one rate for
  // all bands.
  const TestScene<float> scene = wide_scene();
  const ShRun dense = ShTraining(scene, backend(), IdleUpdate::kDense).run();
  const ShRun lazy = ShTraining(scene, backend(), IdleUpdate::kLazy).run();
  EXPECT_GT(dense.idle, 0.5);
  EXPECT_LT(dense.idle, 0.98);
  ASSERT_EQ(lazy.colours.size(), dense.colours.size());
  for (size_t step = 0; step < dense.colours.size(); ++step) {  // caught up before they are drawn
    ASSERT_EQ(lazy.colours[step].size(), dense.colours[step].size());
    for (size_t i = 0; i < dense.colours[step].size(); ++i)
      ASSERT_NEAR(lazy.colours[step][i], dense.colours[step][i], 2e-6) << "step " << step + 1;
  }
  // 50 roundings of a coefficient against one
  const GroupBounds bounds{2e-5, 2e-5, 0, 1e-5};
  for (size_t set = 0; set < 2; ++set) {
    const auto& before = (set == 0 ? scene.fixed : scene.moving).group[kSh];
    expect_group(change(lazy.value[set].group[kSh], before),
                 change(dense.value[set].group[kSh], before), bounds, "sh");
    expect_group(lazy.moment1[set].group[kSh], dense.moment1[set].group[kSh], bounds, "moment1");
    expect_group(lazy.moment2[set].group[kSh], dense.moment2[set].group[kSh], bounds, "moment2");
    for (const int32_t last : lazy.last_step[set]) ASSERT_EQ(last, kSteps);
    for (int g = 0; g < group_count(set == 0 ? 3 : 4); ++g) {
      if (g != kSh)
        expect_group(lazy.moment1[set].group[g], dense.moment1[set].group[g], bounds, "others");
    }
  }
}

TEST_P(BackendLazy, CatchUpEqualsTheCpus) {
  // Bug put back: the last Gaussian of a block left out; seen to fail.
  constexpr int64_t kCount = 3000;
  constexpr int kWidth = 48;
  Random random(52);
  std::vector<int32_t> last(kCount);
  for (int32_t& l : last) l = random.below(kSteps + 1);
  std::vector<float> value(kCount * kWidth), m(kCount * kWidth), v(kCount * kWidth);
  for (size_t i = 0; i < value.size(); ++i) {
    const bool never = last[i / kWidth] == 0 || random.below(10) == 0;
    value[i] = float(random.uniform(-1, 1));
    m[i] = never ? 0 : float(random.uniform(-1e-3, 1e-3));
    v[i] = never ? 0 : float(random.uniform(1e-9, 1e-5));
  }
  const auto caught_up = [&](Backend& on) {
    Memory& there = on.memory();
    Buffer<int32_t> l = stored(last, there);
    Buffer<float> x = stored(value, there), m1 = stored(m, there), m2 = stored(v, there);
    const Buffer<double> table = stored(table_by_its_sum(), there);
    on.catch_up({l.span(), table.span(), x.span(), m1.span(), m2.span(), kSteps, float(kRate),
                 float(kRateRest)});
    EXPECT_EQ(fetched(l, there), std::vector<int32_t>(kCount, kSteps));
    return std::array{fetched(x, there), fetched(m1, there), fetched(m2, there)};
  };
  CpuBackend<float> cpu;
  const auto actual = caught_up(backend()), expected = caught_up(cpu);
  expect_group(change(actual[0], value), change(expected[0], value), {1e-4, 1e-4, 0, 1e-5}, "sh");
  expect_group(actual[1], expected[1], {1e-6, 1e-6, 0, 1e-6}, "moment1");
  expect_group(actual[2], expected[2], {1e-6, 1e-6, 0, 1e-6}, "moment2");
}

}  // namespace
}  // namespace tessera::testing
