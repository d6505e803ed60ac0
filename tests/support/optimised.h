// Parameters with Adam's moments in a backend's memory, and the arguments of an update, with
// made-up rates, one per group.
#pragma once
#include <bit>
#include <type_traits>

#include "tests/support/render.h"

namespace tessera::testing {

/// Both sets of a scene on their way through an optimizer.
template <class Real>
struct Optimised {
  StoredGaussians<Real> value[2], moment1[2], moment2[2], gradient[2];

  /// Moments begin as after a hundred steps of gradients around 1e-3, so that no denominator is
  /// small and rounding stays rounding.
  Optimised(const TestScene<Real>& scene, Memory& memory)
      : value{{scene.fixed, memory}, {scene.moving, memory}},
        moment1{{stored(scene.fixed, 1), memory}, {stored(scene.moving, 1), memory}},
        moment2{{stored(scene.fixed, 2), memory}, {stored(scene.moving, 2), memory}},
        gradient{{empty(scene.fixed), memory}, {empty(scene.moving), memory}} {}

  SinkArgs<Real> sink(size_t set, int64_t step, bool fused, IdleUpdate idle = IdleUpdate::kDense) {
    SinkArgs<Real> args;
    args.fused = fused;
    args.idle = idle;
    args.gradient = gradient[set].spans();
    args.value = value[set].spans();
    args.moment1 = moment1[set].spans();
    args.moment2 = moment2[set].spans();
    for (int g = 0; g < kGroupCount; ++g)
      args.adam.group[g] = adam_scalars<Real>(1e-3 * (g + 1), step);
    args.adam.sh_rest = adam_scalars<Real>(1e-4, step);
    return args;
  }

  static TestGaussians<Real> empty(const TestGaussians<Real>& set) {
    return TestGaussians<Real>(set.form, set.count, set.coefficients, set.time_levels, set.blocks);
  }
  /// Initial values; a packed word holds them exactly.
  static TestGaussians<Real> moments(const TestGaussians<Real>& set, int order) {
    TestGaussians<Real> out = empty(set);
    Random random(uint64_t(100 * order + int(set.form)));
    for (std::vector<Real>& group : out.group)
      for (Real& x : group) {
        const float drawn =
            float(order == 1 ? random.uniform(-1e-3, 1e-3) : random.uniform(1e-6, 2e-6));
        const Moments kept = unpacked_moments(packed_moments({drawn, drawn}, 0));
        x = Real(order == 1 ? kept.m : kept.v);
      }
    return out;
  }
  /// A set's moments one by one, as they are now: m or v.
  TestGaussians<Real> fetch_moments(size_t set, int order) const {
    const TestGaussians<Real> first = moment1[set].fetch();
    TestGaussians<Real> out = order == 1 ? first : moment2[set].fetch();
    for (const Group g : {kSh, kShTime}) {
      if constexpr (!std::is_same_v<Real, float>) break;
      out.group[g].clear();
      for (const Real word : first.group[g]) {
        const Moments kept = unpacked_moments(std::bit_cast<uint32_t>(float(word)));
        out.group[g].push_back(Real(order == 1 ? kept.m : kept.v));
      }
    }
    return out;
  }

 private:
  /// As a backend keeps them: those of SH in words where Real is float.
  static TestGaussians<Real> stored(const TestGaussians<Real>& set, int order) {
    TestGaussians<Real> out = moments(set, order);
    if constexpr (std::is_same_v<Real, float>) {
      const TestGaussians<float> m = moments(set, 1), v = moments(set, 2);
      for (const Group g : {kSh, kShTime}) {
        out.group[g].clear();
        for (size_t i = 0; i < m.group[g].size() && order == 1; ++i)
          out.group[g].push_back(
              std::bit_cast<float>(packed_moments({m.group[g][i], v.group[g][i]}, 0)));
      }
    }
    return out;
  }
};

/// The differences since then, element by element.
template <class Real>
std::vector<double> change(const std::vector<Real>& after, const std::vector<Real>& before) {
  std::vector<double> out(after.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = double(after[i]) - double(before[i]);
  return out;
}

}  // namespace tessera::testing
