// Conversion of dynamic Gaussians to static ones on the CPU.
#include "kernels/edits/demote.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"

namespace tessera {

template <class Real>
void CpuBackend<Real>::demote(const DemoteArgs<Real>& args) {
  constexpr int64_t kElementGrain = 2048;
  check(args.to.count == args.from.count, "demote: a place for every element");
  const ColourRules<Real> colours =
      make_colour_rules<Real>(args.options, args.from.coefficients, args.from.time_levels);
  with_form(args.from.form, [&](auto form) {
    parallel_for(args.from.count, kElementGrain, [&](int64_t begin, int64_t end) {
      for (int64_t n = begin; n < end; ++n)
        store_demoted<form()>(args.from, colours, n, args.timestep[n], args.opacity[n], args.to);
    });
  });
}

template void CpuBackend<float>::demote(const DemoteArgs<float>&);
template void CpuBackend<double>::demote(const DemoteArgs<double>&);

}  // namespace tessera
