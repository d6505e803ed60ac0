// Tests of Buffer, parallel_for, parallel_sort and Camera.
#include "kernels/base/buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <new>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "kernels/base/camera.h"
#include "kernels/base/parallel_sort.h"

namespace tessera::testing {
namespace {

TEST(Buffer, IsAlignedAndKeepsItsCapacity) {
  Buffer<float> b(100);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(b.data()) % 64, 0u);
  const float* first = b.data();
  b.resize(10);
  b.resize(90);
  EXPECT_EQ(b.data(), first);
  EXPECT_EQ(b.size(), 90);
}

/// Of `limit` bytes, which it counts.
struct SmallMemory : Memory {
  size_t limit = 0, used = 0;

  void* allocate(size_t bytes) override {
    if (used + bytes > limit) throw std::bad_alloc();
    used += bytes;
    return host_memory().allocate(bytes);
  }
  void release(void* pointer, size_t bytes) noexcept override {
    used -= bytes;
    host_memory().release(pointer, bytes);
  }
  void copy(void* to, const void* from, size_t bytes) override { std::memcpy(to, from, bytes); }
  int64_t grown(int64_t count, int64_t) const override { return count; }
};

// Bug put back: the old values kept until there are new ones; seen to fail.
TEST(Buffer, GrowsWithoutHoldingTheOldValues) {
  SmallMemory memory;
  memory.limit = 1000;
  Buffer<uint8_t> b(700, memory);
  b.resize(900);
  EXPECT_EQ(b.size(), 900);
  EXPECT_EQ(memory.used, 900u);
  EXPECT_THROW(b.resize(1100), std::bad_alloc);
  EXPECT_TRUE(b.empty());
  EXPECT_EQ(memory.used, 0u);
  b.resize(500);
  EXPECT_THROW(b.grow_keep(600), std::bad_alloc) << "whose values are kept";
  EXPECT_EQ(b.size(), 500);
}

TEST(Buffer, GrowKeepKeepsTheValues) {
  Buffer<int> b(5);
  std::iota(b.begin(), b.end(), 1);
  b.grow_keep(5000);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(b[i], i + 1);
  EXPECT_EQ(b.size(), 5000);
}

TEST(Buffer, MovesLeaveTheSourceEmpty) {
  Buffer<int> a(3);
  a[2] = 7;
  Buffer<int> b(std::move(a));
  EXPECT_EQ(b[2], 7);
  EXPECT_TRUE(a.empty());
  Buffer<int> c(1);
  c = std::move(b);
  EXPECT_EQ(c[2], 7);
  a.resize(4);  // a moved-from buffer can be used again
  EXPECT_EQ(a.size(), 4);
}

TEST(ParallelFor, CoversTheRangeOnceInChunksThatStartAtMultiplesOfTheGrain) {
  for (const int64_t count : {0, 1, 7, 1000, 1024}) {
    std::vector<std::atomic<int>> hits(static_cast<size_t>(count));
    parallel_for(count, 7, [&](int64_t begin, int64_t end) {
      EXPECT_EQ(begin % 7, 0);
      EXPECT_LE(end - begin, 7);
      for (int64_t i = begin; i < end; ++i) ++hits[size_t(i)];
    });
    for (const std::atomic<int>& h : hits) ASSERT_EQ(h, 1);
  }
}

// Bugs put back, each seen to fail: the last round of merging left out; ranges merged with those
// before their neighbours.
TEST(ParallelSort, IsThatOfOneThread) {
  for (const size_t count : {0u, 1u, 16383u, 16384u, 16385u, 49153u, 100000u}) {
    std::vector<uint32_t> values(count);
    uint32_t state = uint32_t(count) + 1;
    for (uint32_t& value : values) value = state = state * 1664525u + 1013904223u;
    std::vector<uint32_t> expected = values;
    std::sort(expected.begin(), expected.end());
    parallel_sort(values);
    EXPECT_EQ(values, expected) << count;
  }
}

TEST(ParallelFor, ExceptionsReachTheCaller) {
  EXPECT_THROW(parallel_for(100, 1,
                            [](int64_t begin, int64_t) {
                              if (begin == 57) throw std::runtime_error("57");
                            }),
               std::runtime_error);
}

// Bug put back: the section is ignored; seen to fail.
TEST(ParallelFor, OfASerialSectionStaysOnItsThread) {
  const auto threads = [] {
    std::mutex lock;
    std::set<std::thread::id> ids;
    parallel_for(64, 1, [&](int64_t, int64_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const std::lock_guard held(lock);
      ids.insert(std::this_thread::get_id());
    });
    return ids;
  };
  {
    const SerialSection outer;
    { const SerialSection inner; }
    EXPECT_EQ(threads(), std::set{std::this_thread::get_id()});
    std::thread([&] { EXPECT_FALSE(SerialSection::is_here()) << "of one thread"; }).join();
  }
  EXPECT_FALSE(SerialSection::is_here());
}

TEST(ParallelFor, ThreadCountCanBeSetAndSetBack) {
  const int machine = thread_count();
  set_thread_count(1);
  EXPECT_EQ(thread_count(), 1);
  set_thread_count(0);
  EXPECT_EQ(thread_count(), machine);
}

TEST(Camera, PositionIsWhereTheCameraFrameHasItsOrigin) {
  Camera c;
  c.cam_from_world = glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1);
  c.translation = {1, 2, 3};
  const glm::dvec3 origin = c.cam_from_world * c.position() + c.translation;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(origin[i], 0, 1e-15);
}

TEST(Camera, ResizedKeepsTheRays) {
  Camera c;
  c.width = 200;
  c.height = 100;
  c.fl_x = 150;
  c.fl_y = 160;
  c.cx = 90;
  c.cy = 55;
  const Camera half = c.resized(100, 50);
  // the right edge of the image and its middle row, as rays
  EXPECT_NEAR((100 - half.cx) / half.fl_x, (200 - c.cx) / c.fl_x, 1e-15);
  EXPECT_NEAR((25 - half.cy) / half.fl_y, (50 - c.cy) / c.fl_y, 1e-15);
}

}  // namespace
}  // namespace tessera::testing
