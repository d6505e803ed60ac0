// Sorts and scans by CUB.
#include "kernels/cuda/sort.h"

#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "kernels/base/errors.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {
namespace {

/// Runs a CUB call twice: for the size of its scratch memory and for its work.
template <class Call>
void with_scratch(Buffer<uint8_t>& scratch, const char* what, Call&& call) {
  size_t bytes = 0;
  check_device(call(nullptr, bytes), what);
  scratch.resize(int64_t(bytes));
  void* memory = scratch.data();
  check_device(call(memory, bytes), what);
}

template <class Key>
void sort(cudaStream_t stream, Span<const Key> keys, Span<const int32_t> values, int key_bits,
          Span<Key> sorted_keys, Span<int32_t> sorted_values, Buffer<uint8_t>& scratch) {
  check(key_bits > 0 && key_bits <= int(8 * sizeof(Key)), "sort_pairs: key bits");
  if (keys.size == 0) return;
  with_scratch(scratch, "radix sort", [&](void* memory, size_t& bytes) {
    return cub::DeviceRadixSort::SortPairs(memory, bytes, keys.data, sorted_keys.data, values.data,
                                           sorted_values.data, keys.size, 0, key_bits, stream);
  });
}

/// counts[order[i]], and 0 behind the last: so that the scan's last sum is the total.
struct OrderedCount {
  const int32_t* counts;
  const int32_t* order;  // null: as they stand
  int64_t size;
  __device__ int64_t operator()(int64_t i) const {
    return i < size ? int64_t(counts[order != nullptr ? order[i] : i]) : 0;
  }
};

void sums_of(cudaStream_t stream, const OrderedCount& count, Span<int64_t> sums,
             Buffer<uint8_t>& scratch) {
  check(sums.size == count.size + 1, "exclusive_sums: sizes");
  const auto in =
      thrust::make_transform_iterator(thrust::make_counting_iterator(int64_t{0}), count);
  with_scratch(scratch, "scan", [&](void* memory, size_t& bytes) {
    return cub::DeviceScan::ExclusiveSum(memory, bytes, in, sums.data, sums.size, stream);
  });
}

}  // namespace

#define TESSERA_SORT(Key)                                                                \
  void sort_pairs(cudaStream_t stream, Span<const Key> keys, Span<const int32_t> values, \
                  int key_bits, Span<Key> sorted_keys, Span<int32_t> sorted_values,      \
                  Buffer<uint8_t>& scratch) {                                            \
    sort<Key>(stream, keys, values, key_bits, sorted_keys, sorted_values, scratch);      \
  }
TESSERA_SORT(uint16_t)
TESSERA_SORT(uint32_t)
TESSERA_SORT(uint64_t)

void exclusive_sums(cudaStream_t stream, Span<const int32_t> counts, Span<int64_t> sums,
                    Buffer<uint8_t>& scratch) {
  sums_of(stream, {counts.data, nullptr, counts.size}, sums, scratch);
}

void exclusive_sums(cudaStream_t stream, Span<const int32_t> counts, Span<const int32_t> order,
                    Span<int64_t> sums, Buffer<uint8_t>& scratch) {
  sums_of(stream, {counts.data, order.data, counts.size}, sums, scratch);
}

int bits_of(int64_t count) {
  int bits = 1;
  while (bits < 62 && (int64_t{1} << bits) < count) ++bits;
  return bits;
}

}  // namespace tessera
