// CUB's radix sort and scan over device spans, with their scratch memory.
#pragma once
#include <cuda_runtime.h>

#include "kernels/base/buffer.h"

namespace tessera {

/// Stable, ascending, on the low `key_bits` bits. Errors: DeviceError.
void sort_pairs(cudaStream_t stream, Span<const uint16_t> keys, Span<const int32_t> values,
                int key_bits, Span<uint16_t> sorted_keys, Span<int32_t> sorted_values,
                Buffer<uint8_t>& scratch);
void sort_pairs(cudaStream_t stream, Span<const uint32_t> keys, Span<const int32_t> values,
                int key_bits, Span<uint32_t> sorted_keys, Span<int32_t> sorted_values,
                Buffer<uint8_t>& scratch);
void sort_pairs(cudaStream_t stream, Span<const uint64_t> keys, Span<const int32_t> values,
                int key_bits, Span<uint64_t> sorted_keys, Span<int32_t> sorted_values,
                Buffer<uint8_t>& scratch);

/// sums[i] = Σ_{j<i} counts[j], in 64 bits; sums has one entry more than counts: the total.
void exclusive_sums(cudaStream_t stream, Span<const int32_t> counts, Span<int64_t> sums,
                    Buffer<uint8_t>& scratch);
/// The same of counts[order[j]].
void exclusive_sums(cudaStream_t stream, Span<const int32_t> counts, Span<const int32_t> order,
                    Span<int64_t> sums, Buffer<uint8_t>& scratch);

/// Bits of the largest of `count` keys 0 … count − 1.
int bits_of(int64_t count);

}  // namespace tessera
