// Matches features along epipolar lines between frames of different times, and refines the offset
// from the matches.
#include "ingest/clocks/motion_matches.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "ingest/poses/epipolar.h"

namespace tessera {
namespace {

constexpr double kSide = 480;  // pixels of the image that misses are counted in

/// A feature's place and velocity at a timestep near its frame, by the parabola through its places.
struct MovingPoint {
  glm::dvec3 place{0.0};     // homogeneous, pixels
  glm::dvec3 velocity{0.0};  // pixels a second
};

MovingPoint moving_point(const MovingFeatures& frame, size_t i, double seconds) {
  const double p = frame.before_seconds - frame.seconds, q = frame.after_seconds - frame.seconds;
  const double t = seconds - frame.seconds;
  const auto point = [](const cv::Point2d& x) { return glm::dvec3(x.x, x.y, 1); };
  const glm::dvec3 middle = point(frame.point[i]);
  const glm::dvec3 u = (point(frame.before[i]) - middle) / p,
                   v = (point(frame.after[i]) - middle) / q;
  const glm::dvec3 bend = (v - u) / (q - p), speed = u - bend * p;
  return {middle + t * (speed + t * bend), speed + 2 * t * bend};
}

/// The cosine of two descriptors.
float likeness(const float* a, const float* b) {
  using Lanes = float __attribute__((vector_size(32)));
  constexpr int kLanes = 8;
  Lanes sum = {}, x, y;
  for (int k = 0; k < kDescriptor; k += kLanes) {
    std::memcpy(&x, a + k, sizeof x);
    std::memcpy(&y, b + k, sizeof y);
    sum += x * y;
  }
  float total = 0;
  for (int i = 0; i < kLanes; ++i) total += sum[i];
  return total;
}

/// The candidates of one feature by likeness, which are cosines.
struct Likest {
  int best = -1;  // index in the other frame
  float likeness = -1, next = -1;

  void offer(int index, float cosine) {
    if (cosine > likeness) {
      next = likeness;
      likeness = cosine;
      best = index;
    } else {
      next = std::max(next, cosine);
    }
  }
  /// Clearly better than the next: of distances, best to second best (Lowe 2004).
  bool is_clear() const {
    constexpr double kRatio = 0.8;
    const auto distance = [](double cosine) { return std::sqrt(std::max(0.0, 2 - 2 * cosine)); };
    return likeness >= 0 && distance(likeness) <= kRatio * distance(next);
  }
};

/// Appends matches that are each other's best within the gate, pixels of b, and clearly better than
/// the next best. `in_b`: seconds of b's clock; `seconds`: of the misses, which count b's pixels as
/// `pixel`.
void match(const glm::dmat3& f, const MovingFeatures& a, const MovingFeatures& b, double in_b,
           double gate, double seconds, double pixel, std::vector<EpipolarMiss>& misses) {
  std::vector<MovingPoint> points;
  std::vector<glm::dvec3> back;
  for (size_t j = 0; j < b.point.size(); ++j) {
    points.push_back(moving_point(b, j, in_b));
    back.push_back(glm::transpose(f) * points.back().place);
  }
  std::vector<Likest> of_a(a.point.size()), of_b(b.point.size());
  const auto line_of = [&](size_t i) { return f * glm::dvec3(a.point[i].x, a.point[i].y, 1); };
  for (size_t i = 0; i < of_a.size(); ++i) {
    const glm::dvec3 line = line_of(i);
    for (size_t j = 0; j < of_b.size(); ++j) {
      if (!EpipolarMatch(points[j].place, line, back[j]).is_within(gate)) continue;
      const float cosine =
          likeness(a.descriptor.ptr<float>(int(i)), b.descriptor.ptr<float>(int(j)));
      of_a[i].offer(int(j), cosine);
      of_b[j].offer(int(i), cosine);
    }
  }
  for (size_t i = 0; i < of_a.size(); ++i) {
    if (!of_a[i].is_clear() || of_b[size_t(of_a[i].best)].best != int(i)) continue;
    const auto j = size_t(of_a[i].best);
    const glm::dvec3 line = line_of(i);
    const EpipolarMatch match(points[j].place, line, back[j]);
    misses.push_back({pixel * match.distance(),
                      pixel * glm::dot(points[j].velocity, line) / std::sqrt(match.square),
                      seconds});
  }
}

bool straight_point(cv::Point2d& point, const RigCamera& rig, const Camera& camera) {
  const auto ray = rig.lens.undistorted(
      {(point.x - camera.cx) / camera.fl_x, (point.y - camera.cy) / camera.fl_y});
  if (!ray) return false;
  point = {camera.fl_x * ray->x + camera.cx, camera.fl_y * ray->y + camera.cy};
  return true;
}

}  // namespace

MovingFeatures straightened(const MovingFeatures& frame, const RigCamera& camera, int width,
                            int height) {
  const Camera sized = camera.camera.resized(width, height);
  MovingFeatures kept{frame.seconds, frame.before_seconds, frame.after_seconds, {}, {}, {}, {}};
  for (size_t i = 0; i < frame.point.size(); ++i) {
    cv::Point2d point = frame.point[i], before = frame.before[i], after = frame.after[i];
    if (!straight_point(point, camera, sized) || !straight_point(before, camera, sized) ||
        !straight_point(after, camera, sized))
      continue;
    kept.point.push_back(point);
    kept.before.push_back(before);
    kept.after.push_back(after);
    kept.descriptor.push_back(frame.descriptor.row(int(i)));
  }
  return kept;
}

std::vector<EpipolarMiss> epipolar_misses(const PosedFeatures& a, const PosedFeatures& b,
                                          const ClockShift& shift, double gate) {
  std::vector<EpipolarMiss> misses;
  const glm::dmat3 f = fundamental(a.camera, b.camera);
  const double pixel = kSide / std::max(b.camera.width, b.camera.height);
  for (const MovingFeatures& frame : a.frames) {
    const double timestep = frame.seconds - shift.at(frame.seconds);
    const auto nearest = std::min_element(
        b.frames.begin(), b.frames.end(), [&](const MovingFeatures& x, const MovingFeatures& y) {
          return std::abs(x.seconds - timestep) < std::abs(y.seconds - timestep);
        });
    if (nearest == b.frames.end() || frame.point.empty() || nearest->point.empty() ||
        std::abs(nearest->seconds - timestep) > 0.6 * b.frame_seconds)
      continue;
    match(f, frame, *nearest, timestep, gate / pixel, frame.seconds - shift.middle, pixel, misses);
  }
  return misses;
}

std::optional<PairShift> fine_offset(const PosedFeatures& a, const PosedFeatures& b, double start) {
  // Clocks of one make differ by 1e-4; 0.15 is a frame lost in seven.
  constexpr double kRateReach = 0.15, kLeastRate = 0.01;
  struct Round {
    double gate, reach;  // pixels, frames
  };
  if (a.frames.empty()) return std::nullopt;
  std::optional<PairShift> found;
  ClockShift shift{start, 0, 0.5 * (a.frames.front().seconds + a.frames.back().seconds)};
  const double frame_seconds = std::max(a.frame_seconds, b.frame_seconds);
  for (const Round& round : {Round{12, 4}, Round{8, 2}, Round{5, 1}, Round{5, 1}}) {
    const bool first = !found;
    found = shift_from_misses(epipolar_misses(a, b, shift, round.gate), round.reach * frame_seconds,
                              frame_seconds, first ? kRateReach : 0);
    if (!found) return std::nullopt;
    shift.offset += found->shift;
    if (std::abs(found->rate) > std::max(5 * found->rate_sigma, kLeastRate)) {
      shift.rate += found->rate;
      found->rate = 0;
    }
  }
  return PairShift{shift.offset, found->sigma, found->support, shift.rate + found->rate,
                   found->rate_sigma};
}

}  // namespace tessera
