// Sets with a Gaussian for every case of density control, and backends to compare with the CPU's.
#pragma once
#include "tests/support/backends.h"
#include "tests/support/random.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {

inline constexpr int64_t kCrowd = 5000;  // more than a block of any kernel

/// Every backend, and the CPU's to compare it with.
class BesideCpu : public EveryBackend {
 protected:
  Backend& cpu() { return cpu_; }

 private:
  CpuBackend<float> cpu_;
};

/// A quarter of it dead, scales from 0.003 to 0.4 world units, some quaternions of no length.
inline TestGaussians<float> crowd(SetForm form, uint64_t seed, int64_t count = kCrowd) {
  Random random(seed);
  TestGaussians<double> set = random_gaussians(form, count, 1, 0.1, random);
  for (double& x : set.group[kOpacityLogit]) x = random.uniform(-8, 2);
  for (double& x : set.group[kLogScale]) x = random.uniform(std::log(0.003), std::log(0.4));
  for (int64_t n = 0; n < count; n += 97) std::fill_n(set.at(kRotation, n), 4, 0.0);
  for (int64_t n = 0; form == SetForm::kPair && n < count; n += 89)
    std::fill_n(set.at(kRotationRight, n), 4, 0.0);
  return set.as<float>();
}

}  // namespace tessera::testing
