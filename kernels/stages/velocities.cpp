// What: velocities of a set, one task a run of Gaussians.
// Not: the equations (math/spacetime.h).
#include "kernels/stages/velocities.h"

#include "kernels/base/parallel.h"
#include "kernels/stages/regulariser.h"

namespace tessera {

template <class Real>
void find_velocities(const GaussianSpans<const Real>& set, Real* velocities) {
  constexpr int64_t kGrain = 512;  // Gaussians per task
  parallel_for(set.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n)
      with_form(set.form, [&](auto form) { store_velocity<form()>(set, n, velocities); });
  });
}

template void find_velocities(const GaussianSpans<const float>&, float*);
template void find_velocities(const GaussianSpans<const double>&, double*);

}  // namespace tessera
