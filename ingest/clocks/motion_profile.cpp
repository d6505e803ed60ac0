// Profiles of motion energy over time and over the planes of the epipolar pencil, and their
// normalised correlation. Source of the epipolar pencil: Hartley and Zisserman, 2004, 9.2.
#include "ingest/clocks/motion_matches.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace tessera {
namespace {

constexpr int kPlanes = 24;

/// Of each cell of the grid: its plane's angle about the base line, radians; NaN: no ray.
std::vector<double> plane_angles(const MotionEnergy& energy, const RigCamera& rig,
                                 const glm::dvec3& u, const glm::dvec3& v) {
  const Camera camera = rig.camera.resized(energy.width, energy.height);
  const cv::Size grid = energy.cells.front().size();
  std::vector<double> angles;
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const glm::dvec2 pixel((x + 0.5) * energy.width / grid.width,
                             (y + 0.5) * energy.height / grid.height);
      const auto ray = rig.lens.undistorted(
          {(pixel.x - camera.cx) / camera.fl_x, (pixel.y - camera.cy) / camera.fl_y});
      if (!ray) {
        angles.push_back(std::nan(""));
        continue;
      }
      const glm::dvec3 direction =
          glm::transpose(camera.cam_from_world) * glm::dvec3(ray->x, ray->y, 1);
      angles.push_back(std::atan2(glm::dot(direction, v), glm::dot(direction, u)));
    }
  return angles;
}

/// Planes of both clips' cells; empty where the centres coincide or nothing is seen by both.
struct Pencil {
  std::vector<double> a, b;  // position in [0, planes) of each cell; NaN: none
  int planes = 0;
};

Pencil pencil_of(const MotionEnergy& a, const MotionEnergy& b, const RigCamera& camera_a,
                 const RigCamera& camera_b) {
  const glm::dvec3 base = camera_b.camera.position() - camera_a.camera.position();
  const glm::dmat3 to_world_a = glm::transpose(camera_a.camera.cam_from_world);
  const glm::dmat3 to_world_b = glm::transpose(camera_b.camera.cam_from_world);
  glm::dvec3 u = to_world_a[2] + to_world_b[2];  // where both look, so that angles lie about 0
  if (!(glm::length(base) > 0)) return {};
  const glm::dvec3 axis = glm::normalize(base);
  u -= glm::dot(u, axis) * axis;
  if (glm::length(u) < 1e-3) u = to_world_a[1] - glm::dot(to_world_a[1], axis) * axis;
  u = glm::normalize(u);
  const glm::dvec3 v = glm::cross(axis, u);
  Pencil pencil{plane_angles(a, camera_a, u, v), plane_angles(b, camera_b, u, v), kPlanes};
  double low = -std::numbers::pi, high = std::numbers::pi;
  for (const auto* angles : {&pencil.a, &pencil.b}) {
    double least = 10, most = -10;
    for (const double angle : *angles)
      if (!std::isnan(angle)) {
        least = std::min(least, angle);
        most = std::max(most, angle);
      }
    low = std::max(low, least);
    high = std::min(high, most);
  }
  if (!(high > low)) return {};
  for (auto* angles : {&pencil.a, &pencil.b})
    for (double& angle : *angles) {
      angle = (angle - low) / (high - low) * kPlanes;
      if (!(angle >= 0 && angle < kPlanes)) angle = std::nan("");
    }
  return pencil;
}

/// [time, plane], at even steps from `begin`.
struct Profile {
  double begin = 0;
  cv::Mat values;  // CV_64F
};

Profile profile_of(const MotionEnergy& energy, const std::vector<double>& planes, int count,
                   double step) {
  const int frames = int(energy.cells.size());
  cv::Mat summed(frames, count, CV_64F, cv::Scalar(0));
  for (int frame = 0; frame < frames; ++frame) {
    const float* cells = energy.cells[size_t(frame)].ptr<float>();
    double* row = summed.ptr<double>(frame);
    for (size_t i = 0; i < planes.size(); ++i) {
      if (std::isnan(planes[i]) || cells[i] <= 0) continue;
      const double plane = std::max(0.0, planes[i] - 0.5);  // shared by the two nearest planes
      const int first = std::min(int(plane), count - 1), second = std::min(first + 1, count - 1);
      row[first] += (1 - (plane - first)) * cells[i];
      row[second] += (plane - first) * cells[i];
    }
  }
  const std::vector<double>& times = energy.seconds;
  const int length = 1 + int((times.back() - times.front()) / step + 1e-6);
  Profile profile{times.front(), cv::Mat(length, count, CV_64F)};
  size_t after = 1;
  for (int i = 0; i < length; ++i) {
    const double t = std::min(times.front() + i * step, times.back());
    while (after + 1 < times.size() && times[after] < t) ++after;
    const double part = (t - times[after - 1]) / (times[after] - times[after - 1]);
    profile.values.row(i) = (1 - part) * summed.row(int(after) - 1) + part * summed.row(int(after));
  }
  cv::sqrt(profile.values, profile.values);  // a near mover is not to drown the others
  return profile;
}

/// Correlation of a(i) with b(i − lag) over their overlap, each plane's mean taken out.
double correlation(const cv::Mat& a, const cv::Mat& b, int lag) {
  const int first = std::max(0, lag), last = std::min(a.rows, b.rows + lag);
  const cv::Mat x = a.rowRange(first, last), y = b.rowRange(first - lag, last - lag);
  cv::Mat mean_x, mean_y;
  cv::reduce(x, mean_x, 0, cv::REDUCE_AVG);
  cv::reduce(y, mean_y, 0, cv::REDUCE_AVG);
  const double n = last - first;
  const double xy = x.dot(y) - n * mean_x.dot(mean_y);
  const double xx = x.dot(x) - n * mean_x.dot(mean_x), yy = y.dot(y) - n * mean_y.dot(mean_y);
  return xx > 0 && yy > 0 ? xy / std::sqrt(xx * yy) : 0;
}

/// The highest point of the curve, as a position in it; nothing where it lies at an end, is low or
/// is hardly higher than another peak.
std::optional<double> clear_peak(const std::vector<double>& curve) {
  constexpr double kLeastHeight = 0.35, kAhead = 0.1;
  const size_t best = size_t(std::max_element(curve.begin(), curve.end()) - curve.begin());
  if (best == 0 || best + 1 >= curve.size() || curve[best] < kLeastHeight) return std::nullopt;
  size_t left = best, right = best;
  while (left > 0 && curve[left - 1] <= curve[left]) --left;
  while (right + 1 < curve.size() && curve[right + 1] <= curve[right]) ++right;
  for (size_t i = 0; i < curve.size(); ++i)
    if ((i < left || i > right) && curve[i] > curve[best] - kAhead) return std::nullopt;
  const double before = curve[best - 1], now = curve[best], after = curve[best + 1];
  const double bend = before - 2 * now + after;
  return double(best) + (bend < 0 ? 0.5 * (before - after) / bend : 0);
}

double median_step(const std::vector<double>& times) {
  std::vector<double> steps;
  for (size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  return median_offset(std::move(steps));
}

}  // namespace

std::optional<PairOffset> coarse_offset(const MotionEnergy& a, const MotionEnergy& b,
                                        const RigCamera& camera_a, const RigCamera& camera_b) {
  constexpr int kFewest = 12;  // frames that overlap
  if (a.cells.size() < size_t(kFewest) || b.cells.size() < size_t(kFewest)) return std::nullopt;
  const Pencil pencil = pencil_of(a, b, camera_a, camera_b);
  if (pencil.planes == 0) return std::nullopt;
  const double step = std::max(median_step(a.seconds), median_step(b.seconds));
  const Profile x = profile_of(a, pencil.a, pencil.planes, step);
  const Profile y = profile_of(b, pencil.b, pencil.planes, step);
  const int shorter = std::min(x.values.rows, y.values.rows);
  const int overlap = std::max(kFewest, shorter / 2);
  const int least = overlap - y.values.rows, most = x.values.rows - overlap;
  if (most - least < 2) return std::nullopt;
  std::vector<double> curve;
  for (int lag = least; lag <= most; ++lag) curve.push_back(correlation(x.values, y.values, lag));
  const std::optional<double> peak = clear_peak(curve);
  if (!peak) return std::nullopt;
  return PairOffset{0, 0, x.begin - y.begin + (*peak + least) * step, step};
}

}  // namespace tessera
