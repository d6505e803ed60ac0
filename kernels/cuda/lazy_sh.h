// What: SH coefficients that are behind take the steps they owe, on the device.
// Not: when: `project` for Gaussians it draws, `catch_up` for all.
#pragma once
#include <cuda_runtime.h>

#include "kernels/gaussians.h"
#include "kernels/math/lazy_adam.h"

namespace tessera {

/// `first_of`: of this set's Gaussians; only those with a splat are brought up to date. Null: all.
/// `gaps`: scratch, [N].
void launch_catch_up(const LazySh<float>& lazy, const int64_t* first_of, LazyGap<float>* gaps,
                     cudaStream_t stream);

}  // namespace tessera
