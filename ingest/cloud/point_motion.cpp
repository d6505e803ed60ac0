// Templates, residuals and normal equations for the displacement of a point.
#include "ingest/cloud/point_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace tessera {
namespace {

constexpr int kSteps = 8;                // of Gauss–Newton, at a level
constexpr double kFarthestStep = 2;      // pixels of the level
constexpr double kSmallStep = 0.02;      // pixels of the level: the last one
constexpr double kOutlier = 6;           // σ: mean difference of a window that counts half, levels
constexpr double kDamping = 1e-3;        // λ by the trace of the normal matrix
constexpr double kLeastDamping = 50;     // λ at least, levels² a pixel²
constexpr float kAgree = 10;             // most difference of windows that agree, levels
constexpr float kAgreeByTexture = 0.6f;  // likewise, by the window's mean absolute deviation
constexpr float kNoWindow = 20;          // difference of a window that leaves its image, levels

struct Projection {
  double u, v;            // pixels
  glm::dvec3 by_u, by_v;  // gradients of u and of v by the world position
};

std::optional<Projection> project(const Camera& camera, const glm::dvec3& point) {
  const glm::dvec3 p = camera.cam_from_world * point + camera.translation;
  if (!(p.z > 0)) return std::nullopt;
  const double fu = camera.fl_x / p.z, fv = camera.fl_y / p.z;
  const glm::dmat3 world_from_cam = glm::transpose(camera.cam_from_world);
  return Projection{fu * p.x + camera.cx, fv * p.y + camera.cy,
                    world_from_cam * glm::dvec3(fu, 0, -fu * p.x / p.z),
                    world_from_cam * glm::dvec3(0, fv, -fv * p.y / p.z)};
}

bool is_used(const Frame& frame, double u, double v) {
  return !frame.mask.ignores(int(u), int(v));
}

/// The window around where the camera has the point, none outside the image or its mask.
std::optional<GreyWindow> window_of(const Frame& frame, const GreyPyramid& image, int level,
                                    const glm::dvec3& point) {
  const auto seen = project(frame.camera, point);
  if (!seen || level >= int(image.size())) return std::nullopt;
  const double u = std::ldexp(seen->u, -level), v = std::ldexp(seen->v, -level);
  if (!has_window(image[size_t(level)], u, v) || !is_used(frame, seen->u, seen->v))
    return std::nullopt;
  return window_at(image[size_t(level)], u, v);
}

float deviation(const GreyWindow& window) {
  float sum = 0;
  for (float level : window.level) sum += std::abs(level);
  return sum / float(GreyWindow::kPixels);
}

/// Of a symmetric matrix that is not negative: the smallest root of its characteristic polynomial.
double least_eigenvalue(const glm::dmat3& m) {
  const double mean = (m[0][0] + m[1][1] + m[2][2]) / 3;
  glm::dmat3 b = m - glm::dmat3(mean);
  double squares = 0;
  for (int i = 0; i < 3; ++i) squares += glm::dot(b[i], b[i]);
  const double spread = std::sqrt(squares / 6);
  if (spread < 1e-12) return mean;
  const double cosine = std::clamp(glm::determinant(b) / (2 * spread * spread * spread), -1.0, 1.0);
  constexpr double kThirdTurn = 2.0943951023931953;
  return mean + 2 * spread * std::cos(std::acos(cosine) / 3 + kThirdTurn);
}

}  // namespace

struct PointMotion::Template {
  GreyWindow window;
  WindowGradient gradient;
  glm::dvec3 by_u, by_v;  // rows of P: pixels of the level by pixels in space
  glm::dmat3 normal;      // Pᵀ A P, levels² a pixel²

  static std::optional<Template> of(const MotionView& view, int level, const glm::dvec3& point,
                                    double pixel);
  glm::dvec3 descent(const GreyWindow& other) const;
};

std::optional<PointMotion::Template> PointMotion::Template::of(const MotionView& view, int level,
                                                               const glm::dvec3& point,
                                                               double pixel) {
  const auto window = window_of(*view.key, *view.image, level, point);
  if (!window) return std::nullopt;
  const auto seen = project(view.key->camera, point);
  const double size = std::ldexp(pixel, -level);
  const WindowGradient gradient = gradient_at(
      (*view.image)[size_t(level)], std::ldexp(seen->u, -level), std::ldexp(seen->v, -level));
  double uu = 0, uv = 0, vv = 0;  // of A
  for (size_t i = 0; i < gradient.along_u.size(); ++i) {
    uu += gradient.along_u[i] * gradient.along_u[i];
    uv += gradient.along_u[i] * gradient.along_v[i];
    vv += gradient.along_v[i] * gradient.along_v[i];
  }
  const glm::dvec3 u = size * seen->by_u, v = size * seen->by_v;
  return Template{*window, gradient, u, v,
                  uu * glm::outerProduct(u, u) + vv * glm::outerProduct(v, v) +
                      uv * (glm::outerProduct(u, v) + glm::outerProduct(v, u))};
}

/// −Pᵀ Σ_x ∇I r.
glm::dvec3 PointMotion::Template::descent(const GreyWindow& other) const {
  float u = 0, v = 0;
  for (size_t i = 0; i < other.level.size(); ++i) {
    const float residual = other.level[i] - window.level[i];
    u += gradient.along_u[i] * residual;
    v += gradient.along_v[i] * residual;
  }
  return -(double(u) * by_u + double(v) * by_v);
}

PointMotion::PointMotion(const glm::dvec3& point, double pixel, std::vector<MotionView> views)
    : point_(point), pixel_(pixel), views_(std::move(views)) {
  for (size_t level = 0; level < templates_.size(); ++level)
    for (const MotionView& view : views_)
      templates_[level].push_back(Template::of(view, int(level), point_ + view.offset, pixel_));
}

PointMotion::~PointMotion() = default;

glm::dvec3 PointMotion::moved(const MotionView& view, const glm::dvec3& displacement,
                              double steps) const {
  return point_ + view.offset + steps * pixel_ * displacement;
}

/// One step of Gauss–Newton; false where it was small, or where no view has a window.
bool PointMotion::step(int level, glm::dvec3& displacement) const {
  glm::dmat3 normal(0.0);
  glm::dvec3 descent(0.0);
  for (size_t i = 0; i < views_.size(); ++i) {
    const std::optional<Template>& made = templates_[size_t(level)][i];
    if (!made) continue;
    for (const MotionView::Other& other : views_[i].others) {
      const auto window =
          window_of(*other.frame, *other.image, level, moved(views_[i], displacement, other.steps));
      if (!window) continue;
      const double apart = difference(made->window, *window) / kOutlier;
      const double weight = 1 / (1 + apart * apart);
      normal += weight * other.steps * other.steps * made->normal;
      descent += weight * other.steps * made->descent(*window);
    }
  }
  const double trace = normal[0][0] + normal[1][1] + normal[2][2];
  if (trace <= 0) return false;
  const glm::dmat3 damped =
      normal + glm::dmat3(kDamping * trace + std::ldexp(kLeastDamping, -2 * level));
  glm::dvec3 change = glm::inverse(damped) * descent;
  const double length = std::ldexp(glm::length(change), -level);  // pixels of the level
  if (length > kFarthestStep) change *= kFarthestStep / length;
  displacement += change;
  return length > kSmallStep;
}

glm::dvec3 PointMotion::refined(glm::dvec3 start, int coarsest) const {
  for (int level = coarsest; level >= 0; --level)
    for (int i = 0; i < kSteps; ++i)
      if (!step(level, start)) break;
  return start;
}

MotionScore PointMotion::score(const glm::dvec3& displacement) const {
  MotionScore score;
  glm::dmat3 normal(0.0);
  int windows = 0;
  for (size_t i = 0; i < views_.size(); ++i) {
    const std::optional<Template>& made = templates_[0][i];
    if (!made) continue;
    const float most = std::min(kAgree, kAgreeByTexture * deviation(made->window));
    float sum = 0;
    for (const MotionView::Other& other : views_[i].others) {
      const auto window =
          window_of(*other.frame, *other.image, 0, moved(views_[i], displacement, other.steps));
      const float apart =
          window ? std::min(kNoWindow, difference(made->window, *window)) : kNoWindow;
      sum += apart;
    }
    const auto others = int(views_[i].others.size());
    score.difference += sum;
    windows += others;
    if (others == 0 || sum > most * float(others)) continue;
    ++score.agreeing;
    normal += made->normal;
  }
  score.difference = windows > 0 ? score.difference / windows : kNoWindow;
  score.information = least_eigenvalue(normal);
  return score;
}

}  // namespace tessera
