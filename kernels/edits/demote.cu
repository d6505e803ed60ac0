// Conversion of dynamic Gaussians to static ones on the device, one thread for each Gaussian.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/edits/demote.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;

struct DemotePass {
  GaussianSpans<const float> from;
  ColourRules<float> colours;
  const float* timestep;
  const float* opacity;
  GaussianSpans<float> to;
};

template <SetForm form>
__global__ void __launch_bounds__(kThreads) demote_elements(DemotePass a) {
  const int64_t n = linear_index();
  if (n < a.from.count)
    store_demoted<form>(a.from, a.colours, n, a.timestep[n], a.opacity[n], a.to);
}

}  // namespace

void CudaBackend::demote(const DemoteArgs<float>& args) {
  check(args.to.count == args.from.count, "demote: a place for every element");
  const DemotePass a{
      args.from,
      make_colour_rules<float>(args.options, args.from.coefficients, args.from.time_levels),
      args.timestep.data, args.opacity.data, args.to};
  with_form(args.from.form, [&](auto form) {
    launch_linear<kThreads>(stream_, "demote", demote_elements<form()>, args.from.count, a);
  });
}

}  // namespace tessera
