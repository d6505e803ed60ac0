// Sizes of the 3D filter and the edits that follow from them, on the device. The file is compiled
// without contraction to fused multiply-adds, so that the sizes equal those of the host. Source:
// method C.1.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/measures/filter_3d.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

/// `largest`: its bits; those of floats ≥ 0 order as they do.
template <SetForm form>
__global__ void measure(GaussianSpans<const float> set, const ViewArgs<float>* views,
                        int64_t view_count, float near_plane, float focal, float time_filter,
                        float* sizes, unsigned* largest) {
  const int64_t n = linear_index();
  float size = -1.0f;
  if (n < set.count) {
    size = filter_size_in<form>(set, n, views, view_count, near_plane, focal, time_filter);
    sizes[n] = size;
  }
  unsigned most = size > 0.0f ? __float_as_uint(size) : 0u;
  for (int step = 16; step > 0; step /= 2) most = max(most, __shfl_xor_sync(~0u, most, step));
  if (threadIdx.x % 32 == 0 && most > 0) atomicMax(largest, most);
}

__global__ void fill_unseen(float* sizes, int64_t count, const unsigned* largest) {
  const int64_t n = linear_index();
  if (n < count && sizes[n] < 0.0f) sizes[n] = __uint_as_float(*largest);
}

__global__ void edit_all(FilterEdit edit, GaussianSpans<float> set, float limit) {
  const int64_t n = linear_index();
  if (n < set.count) edit_by_filter(edit, set, n, limit);
}

}  // namespace

void CudaBackend::filter_sizes(const FilterArgs<float>& args, Span<float> sizes) {
  check(sizes.size == args.set.count, "filter_sizes: one size a Gaussian");
  if (sizes.empty()) return;
  scratch_.resize(sizeof(unsigned));
  unsigned* const largest = reinterpret_cast<unsigned*>(scratch_.data());
  check_device(cudaMemsetAsync(largest, 0, sizeof(unsigned), stream_), "memset");
  with_form(args.set.form, [&](auto form) {
    launch_linear<kThreads>(stream_, "filter_sizes: measure", measure<form()>, sizes.size, args.set,
                            views_of(*args.views), int64_t(args.views->views.size()),
                            args.near_plane, args.focal, args.time_filter, sizes.data, largest);
  });
  launch_linear<kThreads>(stream_, "filter_sizes: fill_unseen", fill_unseen, sizes.size, sizes.data,
                          sizes.size, largest);
}

void CudaBackend::edit_by_filter(FilterEdit edit, const GaussianSpans<float>& set, float limit) {
  check(set.filter_size.size == set.count, "edit_by_filter: one size a Gaussian");
  if (set.count == 0) return;
  launch_linear<kThreads>(stream_, "edit_by_filter: edit_all", edit_all, set.count, edit, set,
                          limit);
}

}  // namespace tessera
