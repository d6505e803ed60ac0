// Curves as pieces of lines: as few as the curve needs, as solid together as the Gaussian was, and
// images of a model whose Gaussians nodes carry stay near.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "static3d/line_motion/line_model.h"
#include "static3d/line_motion/pieces.h"
#include "tests/recon4d/model/carried_model.h"

namespace tessera::testing {
namespace {

using Points = std::vector<CarriedPoint>;

/// A circle of radius 1 about z, of which `share` is gone through in the clip, turned along.
Points arc(double share, int count = 201) {
  Points points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * share * i / (count - 1);
    points.push_back(
        {{std::cos(angle), std::sin(angle), 0}, {std::cos(angle / 2), 0, 0, std::sin(angle / 2)}});
  }
  return points;
}

/// Where the pieces are together at a time, each by how much of it is there.
Vec3<double> place_of(const std::vector<LinePiece>& pieces, double time) {
  Vec3<double> sum(0);
  double weights = 0;
  for (const LinePiece& piece : pieces) {
    const double dt = time - piece.time;
    const double weight = std::exp(-0.5 * dt * dt / (piece.extent * piece.extent));
    weights += weight;
    sum += (piece.mean + piece.velocity * dt) * weight;
  }
  return sum / weights;
}

TEST(LinePieces, ALineIsOne) {
  Points points;
  for (int i = 0; i < 41; ++i) points.push_back({{3 + 0.05 * i, 1, -0.1 * i}, {1, 0, 0, 0}});
  const std::vector<LinePiece> pieces = line_pieces({points}, {0.02, 0.01, 0.001});
  ASSERT_EQ(pieces.size(), 1);
  EXPECT_NEAR(pieces[0].mean.x, 4, 1e-9);
  EXPECT_NEAR(pieces[0].velocity.x, 2, 1e-9);
  EXPECT_NEAR(pieces[0].velocity.z, -4, 1e-9);
  EXPECT_GT(pieces[0].extent, 100);
}

// Bugs put back, each seen to fail: pieces inside of the clip alone; the line through the ends of a
// piece instead of the nearest one.
TEST(LinePieces, ACurveIsFollowedToItsSize) {
  const double size = 0.05;
  const std::vector<LinePiece> pieces = line_pieces({arc(0.5)}, {size, size, size});
  // at the distance of pieces, 1/K, one strays by about (π/K)²/3
  EXPECT_EQ(pieces.size(), 12 + 2);
  for (double time = 0; time <= 1; time += 0.01) {
    const double angle = std::numbers::pi * time;
    const Vec3<double> place = place_of(pieces, time);
    EXPECT_LT(glm::length(place - Vec3<double>(std::cos(angle), std::sin(angle), 0)), 0.25 * size);
  }
}

// Bug put back: turns not looked at; seen to fail.
TEST(LinePieces, WhatTurnsOnThePlaceIsMadeOfPieces) {
  Points points = arc(0.25);
  for (CarriedPoint& point : points) point.mean = {0, 0, 0};
  EXPECT_GT(line_pieces({points}, {0.5, 0.05, 0.05}).size(), 16);
  EXPECT_LE(line_pieces({points}, {0.05, 0.05, 0.05}).size(), 8 + 2);
}

TEST(LinePieces, OneCurveHasNotMoreThanTheMost) {
  EXPECT_EQ(line_pieces({arc(20, 801)}, {1e-6, 1e-6, 1e-6}).size(), kMaxPieces + 2);
}

// Bug put back: each piece as opaque as the Gaussian; seen to fail.
TEST(LinePieces, TogetherCoverWhatTheGaussianDoes) {
  const double side = std::exp(-0.5);  // of a splat, at one standard deviation
  for (const double opacity : {0.02, 0.3, 0.8, 0.99}) {
    const std::vector<LinePiece> pieces = line_pieces({arc(0.5)}, {0.05, 0.05, 0.05});
    for (double time = 0.02; time < 1; time += 0.03) {
      double through = 1;
      for (const LinePiece& piece : pieces) {
        const double deviations = (time - piece.time) / piece.extent;
        through *= 1 - side * piece_opacity(opacity) * std::exp(-0.5 * deviations * deviations);
      }
      EXPECT_NEAR(1 - through, side * opacity, 0.06 * opacity) << opacity << " at " << time;
    }
  }
}

// Bugs put back, each seen to fail: the life left as it was under that of its pieces; pieces as
// opaque at the end of the life as in its middle.
TEST(LinePieces, OfALifeFadeTogetherAsItDoes) {
  Curve curve{arc(0.5), {0.1, 0.9}, 0.45, 0.12};
  const std::vector<LinePiece> pieces = line_pieces(curve, {0.05, 0.05, 0.05});
  ASSERT_GT(pieces.size(), 8);
  const double distance = pieces[1].time - pieces[0].time;
  const double whole = std::sqrt(2 * std::numbers::pi) * pieces[0].extent / distance;
  for (double time = 0.15; time < 0.75; time += 0.01) {
    double sum = 0;
    for (const LinePiece& piece : pieces) {
      const double deviations = (time - piece.time) / piece.extent;
      sum += piece.share * std::exp(-0.5 * deviations * deviations);
    }
    const double deviations = (time - curve.centre) / curve.extent;
    EXPECT_NEAR(sum / whole, std::exp(-0.5 * deviations * deviations), 0.01) << time;
  }
}

// Bug put back: rows of a part of the set by their place in it; seen to fail.
TEST(CarriedLines, ImagesStayNearWhatTheyWere) {
  const GaussianModel model = carried_model(kBindings, 1100);
  const WindowModels whole{{FileWindow{}}, [&](int) { return model.clone_values(); }};
  const GaussianModel lines = line_model(whole, model);
  EXPECT_TRUE(lines.nodes.empty());
  EXPECT_EQ(lines.static_set.count(), 0);
  EXPECT_GT(lines.dynamic_set.count(), model.static_set.count());
  EXPECT_GT(likeness(lines, model, {0.0, 0.3, 0.62, 1.0}), 30);
}

}  // namespace
}  // namespace tessera::testing
