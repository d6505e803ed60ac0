// Demotion: the choice of dynamic Gaussians that become static. All candidates are tried at once
// over all cameras and timesteps, and the added error is divided among them by blending weight.
// Source: docs/explanation/static-dynamic.md; idea of a Gaussian that gives up its time:
// [Hybrid4D].
#pragma once
#include "recon4d/reduction/contributions.h"

namespace tessera {

/// Gaussians of a dynamic set as static ones: where and as opaque as they are on the average of
/// their light, with the shape and colours of their slice there. Elements without blending weight
/// or that are no Gaussians are where their own timestep has them. Where the backend works.
GaussianSet as_static(Backend& backend, const GaussianModel& model,
                      const SetContributions& contributions);

struct DemotionTrial {
  explicit DemotionTrial(Memory& memory = host_memory())
      : demoted(SetForm::kStatic, kMaxShCoefficients, memory) {}

  std::vector<int64_t> elements;  // of the dynamic set that may be static, ascending
  GaussianSet demoted;            // [elements] what they become, where the backend works
  /// Squared error that all of them add; where the last round has taken some away, the sum of the
  /// shares that the others had in it.
  double error = 0;
};
/// Where masks say what moves, those are tried of whose light no more than a quarter lies in pixels
/// that may. `allowed`: squared error over all frames that one of them may add; `rounds`: how often
/// those that are left are tried, at most.
DemotionTrial try_demotion(Backend& backend, const GaussianModel& model,
                           const Contributions& contributions, const FrameSample& sample,
                           double allowed, int rounds = 4);

}  // namespace tessera
