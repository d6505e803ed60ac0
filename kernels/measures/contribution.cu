// Sums of splats for each Gaussian and sums over images, on the device, with one thread for each
// Gaussian or pixel.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_sum.cuh"
#include "kernels/cuda/launch.cuh"
#include "kernels/measures/contribution.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;

struct ContributionPass {
  GaussianSpans<const float> set;
  int64_t first;  // of its elements, in the splats' numbering
  const ViewArgs<float>* views;
  ColourRules<float> colours;
  float time_filter;
  const int64_t* first_of;
  const Splat<float>* splats;
  const SplatSensitivity<float>* sums;
  ElementSums<float>* elements;
  TimeVariation* variation;  // of the static set, or nullptr
};

template <SetForm form>
__global__ void __launch_bounds__(kThreads) add_elements(ContributionPass a) {
  const int64_t n = linear_index();
  if (n >= a.set.count) return;
  const int64_t from = a.first_of[a.first + n], to = a.first_of[a.first + n + 1];
  GaussianState<float> g;
  if (from == to || !load_gaussian<form>(a.set, n, g)) return;
  TimeVariation* const variation =
      !is_dynamic(form) && a.variation != nullptr ? a.variation + a.first + n : nullptr;
  ElementSums<float> sums = a.elements[a.first + n];
  for (int64_t s = from; s < to; ++s) {
    const int b = a.splats[s].view;
    GaussianState<float> room;
    add_splat(a.views[b], a.colours, a.time_filter, state_in_view<form>(a.set, n, b, g, room),
              a.splats[s], a.sums[s], sums, variation);
  }
  a.elements[a.first + n] = sums;
}

__global__ void __launch_bounds__(kThreads)
    add_squares(const float* before, float* residual, int64_t pixels) {
  const int64_t p = linear_index();
  if (p < pixels) write_added_squares(before, residual, pixels, p);
}

struct Square {
  __device__ double operator()(float value) const { return double(value) * double(value); }
};

}  // namespace

void CudaBackend::contributions(const ContributionArgs<float>& args) {
  check(args.sums.size == args.splats->count, "contributions: one sum a splat");
  const RenderOptions& options = args.forward.options;
  int64_t first = 0;
  for (const GaussianSpans<const float>& set : args.forward.sets) {
    for_each_block(set.blocks, set.count, set.coefficients, [&](const ShBlock& block) {
      const GaussianSpans<const float> elements = set.block(block);
      const ContributionPass a{
          elements,
          first + block.first,
          views_of(*args.forward.batch),
          make_colour_rules<float>(options, elements.coefficients, elements.time_levels),
          float(options.time_filter),
          args.splats->first_of.data(),
          args.splats->splat.data(),
          args.sums.data,
          args.elements.data,
          args.variation.data};
      with_drawn_form(set.form, [&](auto form) {
        launch_linear<kThreads>(stream_, "contributions", add_elements<form()>, elements.count, a);
      });
    });
    first += set.count;
  }
}

void CudaBackend::added_squares(const ViewBatch<float>& batch, Span<const float> before,
                                Span<float> residual) {
  for (const ViewArgs<float>& view : batch.views) {
    const int64_t pixels = int64_t(view.width) * view.height, first = 3 * view.first_pixel;
    launch_linear<kThreads>(stream_, "added_squares", add_squares, pixels, before.data + first,
                            residual.data + first, pixels);
  }
}

double CudaBackend::sum_of_squares(Span<const float> values) {
  return device_sum(stream_, values.data, values.size, Square{}, scratch_, sort_scratch_, memory_,
                    "sum_of_squares");
}

}  // namespace tessera
