// A sum in double over elements of the device's memory.
#pragma once
#include <cub/device/device_reduce.cuh>

#include "kernels/base/buffer.h"
#include "kernels/base/errors.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {

struct Plus {
  __device__ double operator()(double a, double b) const { return a + b; }
};

/// Σ term(first[i]) of `count` elements. Equal inputs give equal bits. Waits. `scratch`, `library`:
/// what is in them is lost; `what`: for errors.
template <class Iterator, class Term>
double device_sum(cudaStream_t stream, Iterator first, int64_t count, Term term,
                  Buffer<uint8_t>& scratch, Buffer<uint8_t>& library, Memory& memory,
                  const char* what) {
  size_t bytes = 0;
  scratch.resize(sizeof(double));
  double* const sum = reinterpret_cast<double*>(scratch.data());
  const auto reduce = [&](void* room) {
    check_device(cub::DeviceReduce::TransformReduce(room, bytes, first, sum, count, Plus{}, term,
                                                    0.0, stream),
                 what);
  };
  reduce(nullptr);
  library.resize(int64_t(bytes));
  reduce(library.data());
  double result = 0;
  memory.copy(&result, sum, sizeof(result));
  return result;
}

}  // namespace tessera
