// Compares clouds, to the bit.
#pragma once
#include <gtest/gtest.h>

#include "ingest/scene.h"

namespace tessera::testing {

inline void expect_equal(const PointCloud& one, const PointCloud& other) {
  EXPECT_EQ(one.position, other.position);
  EXPECT_EQ(one.colour, other.colour);
  EXPECT_EQ(one.time, other.time);
  EXPECT_EQ(one.still, other.still);
  EXPECT_EQ(one.velocity, other.velocity);
}

}  // namespace tessera::testing
