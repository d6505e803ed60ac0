// Matches features along epipolar lines between frames of different times, and refines the offset
// from the matches. Source of the Sampson distance: Hartley and Zisserman, 2004, 11.4.3.
#include "ingest/clocks/motion_matches.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace tessera {
namespace {

constexpr double kSide = 480;  // pixels of the image that misses are counted in

glm::dmat3 cross_matrix(const glm::dvec3& t) {
  return {{0, t.z, -t.y}, {-t.z, 0, t.x}, {t.y, -t.x, 0}};  // by column
}

glm::dmat3 pixels_of(const Camera& camera) {
  return {{camera.fl_x, 0, 0}, {0, camera.fl_y, 0}, {camera.cx, camera.cy, 1}};
}

/// x_bᵀ F x_a = 0.
glm::dmat3 fundamental(const Camera& a, const Camera& b) {
  const glm::dmat3 turn = b.cam_from_world * glm::transpose(a.cam_from_world);
  const glm::dvec3 move = b.translation - turn * a.translation;
  return glm::transpose(glm::inverse(pixels_of(b))) * cross_matrix(move) * turn *
         glm::inverse(pixels_of(a));
}

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

/// Miss and slope of every pair of features; rows a, columns b.
struct MissTable {
  cv::Mat miss, slope;  // CV_64F
};

MissTable miss_table(const glm::dmat3& f, const MovingFeatures& a, const MovingFeatures& b,
                     double seconds_in_b, double pixel) {
  const int rows = int(a.point.size()), columns = int(b.point.size());
  MissTable table{cv::Mat(rows, columns, CV_64F), cv::Mat(rows, columns, CV_64F)};
  std::vector<MovingPoint> points;
  for (size_t j = 0; j < b.point.size(); ++j) points.push_back(moving_point(b, j, seconds_in_b));
  for (int i = 0; i < rows; ++i) {
    const glm::dvec3 from(a.point[size_t(i)].x, a.point[size_t(i)].y, 1), line = f * from;
    for (int j = 0; j < columns; ++j) {
      const MovingPoint& to = points[size_t(j)];
      const glm::dvec3 back = glm::transpose(f) * to.place;
      const double length =
          std::sqrt(line.x * line.x + line.y * line.y + back.x * back.x + back.y * back.y);
      table.miss.at<double>(i, j) = pixel * glm::dot(to.place, line) / length;
      table.slope.at<double>(i, j) = pixel * glm::dot(to.velocity, line) / length;
    }
  }
  return table;
}

/// Appends matches that are each other's best within the gate, clearly better than the next best;
/// `seconds` is their time.
void match(const MovingFeatures& a, const MovingFeatures& b, const MissTable& table, double gate,
           double seconds, std::vector<EpipolarMiss>& misses) {
  constexpr double kRatio = 0.8;  // of distances, best to second best (Lowe 2004)
  cv::Mat likeness = a.descriptor * b.descriptor.t();  // cosines
  const auto distance = [](double cosine) { return std::sqrt(std::max(0.0, 2 - 2 * cosine)); };
  for (int i = 0; i < likeness.rows; ++i)
    for (int j = 0; j < likeness.cols; ++j)
      if (!(std::abs(table.miss.at<double>(i, j)) < gate)) likeness.at<float>(i, j) = -1;
  for (int i = 0; i < likeness.rows; ++i) {
    double best = -1, next = -1;
    cv::Point location, other;
    cv::Mat row = likeness.row(i).clone();
    cv::minMaxLoc(row, nullptr, &best, nullptr, &location);
    if (best < 0) continue;
    row.at<float>(0, location.x) = -1;
    cv::minMaxLoc(row, nullptr, &next);
    cv::minMaxLoc(likeness.col(location.x), nullptr, nullptr, nullptr, &other);
    if (other.y != i || distance(best) > kRatio * distance(next)) continue;
    misses.push_back(
        {table.miss.at<double>(i, location.x), table.slope.at<double>(i, location.x), seconds});
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

void straighten(std::vector<MovingFeatures>& features, const RigCamera& camera, int width,
                int height) {
  const Camera sized = camera.camera.resized(width, height);
  for (MovingFeatures& frame : features) {
    MovingFeatures kept{frame.seconds, frame.before_seconds, frame.after_seconds, {}, {}, {}, {}};
    for (size_t i = 0; i < frame.point.size(); ++i) {
      if (!straight_point(frame.point[i], camera, sized) ||
          !straight_point(frame.before[i], camera, sized) ||
          !straight_point(frame.after[i], camera, sized))
        continue;
      kept.point.push_back(frame.point[i]);
      kept.before.push_back(frame.before[i]);
      kept.after.push_back(frame.after[i]);
      kept.descriptor.push_back(frame.descriptor.row(int(i)));
    }
    frame = std::move(kept);
  }
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
    match(frame, *nearest, miss_table(f, frame, *nearest, timestep, pixel), gate,
          frame.seconds - shift.middle, misses);
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
