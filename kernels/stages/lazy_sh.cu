// What: the closed form of idle Adam steps, its factors once a Gaussian, then four scalars a
// thread.
// Not: the closed form itself (math/lazy_adam.h).
// Source: method G.3.
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/lazy_sh.h"

namespace tessera {
namespace {

constexpr int kThreads = 192;

/// decay1 < 0 marks a Gaussian that owes nothing or is not drawn.
__global__ void find_gaps(LazySh<float> lazy, const int64_t* first_of, LazyGap<float>* gaps) {
  const int64_t n = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (n >= lazy.last_step.size) return;
  const bool wanted = first_of == nullptr || first_of[n] != first_of[n + 1];
  const int64_t last = lazy.last_step[n];
  LazyGap<float> gap{0, -1, 0, 0};
  if (wanted && last < lazy.step) {
    gap = lazy_gap<float>(lazy.table.data, last, lazy.step);
    lazy.last_step[n] = int32_t(lazy.step);
  }
  gaps[n] = gap;
}

template <int Scalars>
struct alignas(4 * Scalars) Lane {
  float at[Scalars];
};

/// Scalars of a group, the first three of a row with a rate of their own.
struct LazyGroup {
  Span<float> value, moment1, moment2;  // [N, width]
  float rate, rate_rest;
};

template <int Scalars>
__global__ void __launch_bounds__(kThreads)
    catch_up(LazyGroup group, int64_t gaussians, int width, const LazyGap<float>* gaps) {
  const int64_t at = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  const int per_gaussian = width / Scalars;
  const int64_t n = at / per_gaussian;
  if (n >= gaussians) return;
  const LazyGap<float> gap = gaps[n];
  if (gap.decay1 < 0) return;
  const int first = int(at - n * per_gaussian) * Scalars;
  auto* const values = reinterpret_cast<Lane<Scalars>*>(group.value.data) + at;
  auto* const moments1 = reinterpret_cast<Lane<Scalars>*>(group.moment1.data) + at;
  auto* const moments2 = reinterpret_cast<Lane<Scalars>*>(group.moment2.data) + at;
  Lane<Scalars> x = *values, m = *moments1, v = *moments2;
  TESSERA_UNROLL
  for (int j = 0; j < Scalars; ++j)
    lazy_catch_up(gap, first + j < 3 ? group.rate : group.rate_rest, x.at[j], m.at[j], v.at[j]);
  *values = x, *moments1 = m, *moments2 = v;
}

/// `N` rows of equal widths.
void launch_group(const LazyGroup& group, int64_t N, const LazyGap<float>* gaps,
                  cudaStream_t stream) {
  const int width = int(group.value.size / N);
  if (width == 0) return;
  if (width % 4 == 0)
    catch_up<4><<<grid_of(N * width / 4, kThreads), kThreads, 0, stream>>>(group, N, width, gaps);
  else
    catch_up<1><<<grid_of(N * width, kThreads), kThreads, 0, stream>>>(group, N, width, gaps);
  check_launch("catch_up");
}

}  // namespace

void launch_catch_up(const LazySh<float>& lazy, const int64_t* first_of, LazyGap<float>* gaps,
                     cudaStream_t stream) {
  const int64_t N = lazy.last_step.size;
  find_gaps<<<grid_of(N, 128), 128, 0, stream>>>(lazy, first_of, gaps);
  lazy.for_each_block([&](const ShBlock& block) {
    const LazySh<float> rows = lazy.block(block);
    launch_group({rows.value, rows.moment1, rows.moment2, rows.rate, rows.rate_rest}, block.count,
                 gaps + block.first, stream);
    launch_group(
        {rows.time_value, rows.time_moment1, rows.time_moment2, rows.rate_rest, rows.rate_rest},
        block.count, gaps + block.first, stream);
  });
}

}  // namespace tessera
