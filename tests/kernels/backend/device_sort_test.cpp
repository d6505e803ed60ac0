// The sort of a hundred million keys on the device is stable and equals that of std::sort, for
// every key width. Source: failure mode C7.
#include <algorithm>

#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/sort.h"
#include "tests/support/backends.h"
#include "tests/support/random.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {
namespace {

class DeviceSort : public EveryBackend {};
TESSERA_ON_DEVICES(DeviceSort);

/// Pairs of (key, place) in the order of std::sort: as places differ, that is the stable one.
template <class Key>
void expect_sorted(CudaBackend& device, const std::vector<Key>& keys, int key_bits) {
  Memory& memory = device.memory();
  const int64_t count = int64_t(keys.size());
  std::vector<int32_t> places(keys.size());
  for (size_t i = 0; i < places.size(); ++i) places[i] = int32_t(i);
  Buffer<Key> sorted_keys(count, memory);
  Buffer<int32_t> sorted_places(count, memory);
  Buffer<uint8_t> scratch(memory);
  {
    const Buffer<Key> unsorted = stored(keys, memory);
    const Buffer<int32_t> values = stored(places, memory);
    sort_pairs(device.stream(), unsorted.span(), values.span(), key_bits, sorted_keys.span(),
               sorted_places.span(), scratch);
  }
  std::vector<std::pair<Key, int32_t>> expected(keys.size());
  for (size_t i = 0; i < keys.size(); ++i) expected[i] = {keys[i], places[i]};
  std::sort(expected.begin(), expected.end());
  const std::vector<Key> actual_keys = fetched(sorted_keys, memory);
  const std::vector<int32_t> actual_places = fetched(sorted_places, memory);
  for (size_t i = 0; i < keys.size(); ++i) {
    ASSERT_EQ(actual_keys[i], expected[i].first) << "at " << i;
    ASSERT_EQ(actual_places[i], expected[i].second) << "at " << i;
  }
}

template <class Key>
std::vector<Key> random_keys(int64_t count, int bits, uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<Key> keys(static_cast<size_t>(count));
  for (Key& key : keys) key = Key(engine() >> (64 - bits));
  return keys;
}

TEST_P(DeviceSort, HundredMillionTileKeysEqualStdSort) {  // C7
  CudaBackend device;
  expect_sorted(device, random_keys<uint16_t>(100'000'000, 14, 1), 14);
}

TEST_P(DeviceSort, HundredMillionDepthKeysEqualStdSort) {  // C7
  CudaBackend device;
  expect_sorted(device, random_keys<uint32_t>(100'000'000, 32, 2), 32);
}

TEST_P(DeviceSort, EveryWidthAndSmallCounts) {
  CudaBackend device;
  for (const int64_t count : {0, 1, 31, 5000, 1'000'003}) {
    expect_sorted(device, random_keys<uint16_t>(count, 16, 3), 16);
    expect_sorted(device, random_keys<uint32_t>(count, 20, 4), 20);
    expect_sorted(device, random_keys<uint64_t>(count, 49, 5), 49);
  }
}

TEST_P(DeviceSort, BitsOfCountHoldTheLargestKey) {
  EXPECT_EQ(bits_of(2), 1);
  EXPECT_EQ(bits_of(256), 8);
  EXPECT_EQ(bits_of(257), 9);
  EXPECT_EQ(bits_of(int64_t{1} << 31), 31);
  EXPECT_GE(bits_of(1), 0);
}

}  // namespace
}  // namespace tessera::testing
