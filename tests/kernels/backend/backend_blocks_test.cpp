// Sets whose elements differ in SH degree, on every backend, against sets of full elements whose
// missing bands are zero and held at zero. Results are equal bit for bit, because the arithmetic is
// the same. The arrangement of elements in blocks is tested in
// tests/recon4d/model/train_blocks_test.cpp.
#include "tests/support/backends.h"
#include "tests/support/optimised.h"
#include "tests/support/sh_degrees.h"

namespace tessera::testing {
namespace {

/// Both sets in full elements, sorted as the blocks are, missing bands zero.
struct Sorted {
  TestScene<float> full;
  ShBlocks blocks[2];

  TestScene<float> in_blocks() const {
    TestScene<float> scene = full;
    scene.fixed = tessera::testing::in_blocks(full.fixed, blocks[0]);
    scene.moving = tessera::testing::in_blocks(full.moving, blocks[1]);
    return scene;
  }
};

/// The scene with degrees for all elements.
Sorted sorted(TestScene<double> scene, uint64_t seed) {
  Sorted out;
  TestGaussians<double>* const sets[2] = {&scene.fixed, &scene.moving};
  for (size_t k = 0; k < 2; ++k) {
    const std::vector<uint8_t> degrees = some_degrees(sets[k]->count, seed + k);
    out.blocks[k] = blocks_of(degrees);
    *sets[k] = held(sets[k]->select(block_order(degrees)), out.blocks[k]);
  }
  keep_truth_away(scene, seed + 2);
  scene.options.kernels.deterministic = true;
  scene.options.sh_time_period = 0.9;
  out.full = scene.as<float>();
  return out;
}

/// Seen by all of three views.
Sorted sorted_scene(SetForm form, int levels, uint64_t seed) {
  TestScene<double> scene = random_scene(90, 120, 0.12, seed, form);
  if (levels > 0) add_time_levels(scene.moving, levels, seed + 1);
  return sorted(std::move(scene), seed + 2);
}

/// All around three narrow views, each of which sees some.
Sorted wide_scene(SetForm form, int levels, uint64_t seed) {
  Random random(seed);
  TestScene<double> scene;
  scene.fixed = random_gaussians(SetForm::kStatic, 150, 3, 0.1, random);
  scene.moving = random_gaussians(form, 150, 3, 0.1, random);
  add_time_levels(scene.moving, levels, seed + 1);
  for (int k = 0; k < 3; ++k)
    scene.views.push_back(
        {look_at({0.1, 0.2, 0}, {std::cos(2 * k), 0.2, std::sin(2 * k)}, 48, 33, 30),
         0.3 + 0.15 * k});
  fill_truth(scene, random);
  return sorted(std::move(scene), seed + 2);
}

void expect_equal(const TestGaussians<float>& actual, const TestGaussians<float>& full,
                  const ShBlocks& blocks, const char* what) {
  const TestGaussians<float> expected = in_blocks(full, blocks);
  for (int g = 0; g < group_count(actual.form); ++g)
    EXPECT_EQ(actual.group[g], expected.group[g]) << what << " " << group_name(Group(g), full.form);
}

class BackendBlocks : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendBlocks);

TEST_P(BackendBlocks, ImagesAndGradientsAreThoseOfFullElements) {
  // Bugs put back, each seen to fail: splats of the set's first elements taken for a block's; the
  // statistics of the first elements.
  struct Case {
    SetForm form;
    int levels, degree;
  };
  for (const auto& [form, levels, degree] :
       {Case{SetForm::kPair, 0, 3}, Case{SetForm::kVelocity, 2, 3}, Case{SetForm::kPair, 1, 2}}) {
    SCOPED_TRACE(std::string(form_name(form)) + ", levels " + std::to_string(levels));
    Sorted scene = sorted_scene(form, levels, 301);
    scene.full.options.sh_degree = degree;
    scene.full.regulariser = {0.01, 0.01};
    const Backward<float> actual = backward(scene.in_blocks(), backend());
    const Backward<float> full = backward(scene.full, backend());
    EXPECT_EQ(actual.bad, 0u);
    EXPECT_EQ(actual.rendered.colour, full.rendered.colour);
    EXPECT_EQ(actual.rendered.transmittance, full.rendered.transmittance);
    expect_equal(actual.fixed, full.fixed, scene.blocks[0], "static");
    expect_equal(actual.moving, full.moving, scene.blocks[1], "dynamic");
    for (size_t set = 0; set < 2; ++set) {
      EXPECT_EQ(actual.statistic[set], full.statistic[set]);
      EXPECT_EQ(actual.seen[set], full.seen[set]);
    }
  }
}

TEST_P(BackendBlocks, ReportsColoursThatAreNotFinite) {  // C20
  // Bug put back: what one block reports overwrites what those before did; seen to fail.
  Sorted sets = sorted_scene(SetForm::kVelocity, 1, 303);
  TestGaussians<float>* const full[2] = {&sets.full.fixed, &sets.full.moving};
  for (size_t k = 0; k < 2; ++k)  // nothing of the last block is drawn
    for (int64_t n = full[k]->count - sets.blocks[k].elements[0]; n < full[k]->count; ++n)
      *full[k]->at(kOpacityLogit, n) = -8;
  const TestScene<float> scene = sets.in_blocks();
  const auto result = backward<float>(scene, backend(), [](std::vector<float>& d) {
    for (float& x : d) x = std::numeric_limits<float>::quiet_NaN();
  });
  EXPECT_EQ(result.bad, (1u << kDynamicGroups) - 1);
}

/// A set on its way through an optimizer, on the host between the steps.
struct Trained {
  TestGaussians<float> value, moment1, moment2;

  explicit Trained(const TestGaussians<float>& set)
      : value(set), moment1(Optimised<float>::empty(set)), moment2(Optimised<float>::empty(set)) {}
};

constexpr int64_t kSteps = 7;
constexpr double kRate = 2.5e-3, kRateRest = 1.25e-4;

/// The buffers of a set for one step.
struct OnBackend {
  StoredGaussians<float> value, moment1, moment2, gradient;

  OnBackend(const Trained& set, Memory& memory)
      : value(set.value, memory),
        moment1(set.moment1, memory),
        moment2(set.moment2, memory),
        gradient(Optimised<float>::empty(set.value), memory) {}

  SinkArgs<float> sink(int64_t step, bool fused) {
    SinkArgs<float> args;
    args.fused = fused;
    args.gradient = gradient.spans();
    args.value = value.spans();
    args.moment1 = moment1.spans();
    args.moment2 = moment2.spans();
    for (int g = 0; g < kGroupCount; ++g)
      args.adam.group[g] = adam_scalars<float>(g == kSh ? kRate : 1e-4 * (g + 1), step);
    args.adam.sh_rest = adam_scalars<float>(kRateRest, step);
    return args;
  }
  void fetch(Trained& set) const {
    set.value = value.fetch();
    set.moment1 = moment1.fetch();
    set.moment2 = moment2.fetch();
  }
};

/// Seven steps, one of three views at a time, so that most Gaussians are idle in most of them.
/// `hold`: the blocks whose bands full elements keep at zero.
std::vector<Trained> train(const TestScene<float>& scene, Backend& backend, bool fused,
                           IdleUpdate idle, const ShBlocks* hold) {
  Memory& memory = backend.memory();
  const StoredScene<float> in(scene, memory);
  std::vector<Trained> sets{Trained(scene.fixed), Trained(scene.moving)};
  for (int64_t step = 1; step <= kSteps; ++step) {
    OnBackend on_backend[2]{{sets[0], memory}, {sets[1], memory}};
    const size_t view = size_t(step % 3);
    Pipeline<float> pipeline(backend);
    ForwardArgs<float> forward = in.forward(true);
    BackwardArgs<float> args;
    for (size_t k = 0; k < 2; ++k) {
      forward.sets[k] = std::as_const(on_backend[k].value).view();
      args.sinks[k] = on_backend[k].sink(step, fused);
      args.sinks[k].idle = idle;
    }
    forward.views = {in.views[view]};
    pipeline.forward(forward);
    pipeline.loss({{in.truth[view].span()}, in.weights, {}}, true);
    pipeline.backward(args);
    for (size_t k = 0; k < 2 && !fused; ++k) backend.adam(args.sinks[k]);
    EXPECT_EQ(pipeline.outcome().bad_groups, 0u);
    for (size_t k = 0; k < 2; ++k) {
      on_backend[k].fetch(sets[k]);
      if (hold == nullptr) continue;
      for (TestGaussians<float>* set : {&sets[k].value, &sets[k].moment1, &sets[k].moment2})
        *set = held(*set, hold[k]);
    }
  }
  return sets;
}

TEST_P(BackendBlocks, OptimizersStepAsThoseOfFullElements) {
  // Bug put back: the separate optimizer on the first elements of the set for every block; seen to
  // fail.
  struct Case {
    bool fused;
    IdleUpdate idle;
  };
  const Sorted scene = wide_scene(SetForm::kVelocity, 2, 305);
  for (const auto& [fused, idle] : {Case{true, IdleUpdate::kDense}, Case{false, IdleUpdate::kDense},
                                    Case{true, IdleUpdate::kSkip}}) {
    SCOPED_TRACE("fused " + std::to_string(fused) + ", idle " + std::to_string(int(idle)));
    const auto actual = train(scene.in_blocks(), backend(), fused, idle, nullptr);
    const auto full = train(scene.full, backend(), fused, idle, scene.blocks);
    for (size_t k = 0; k < 2; ++k) {
      expect_equal(actual[k].value, full[k].value, scene.blocks[k], "value");
      expect_equal(actual[k].moment1, full[k].moment1, scene.blocks[k], "moment1");
      expect_equal(actual[k].moment2, full[k].moment2, scene.blocks[k], "moment2");
    }
    EXPECT_NE(actual[1].value.group[kSh], scene.in_blocks().moving.group[kSh]);
  }
}

}  // namespace
}  // namespace tessera::testing
