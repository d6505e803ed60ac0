// A renderer written as plain loops from the formulas: every pixel visits every Gaussian, sorted by
// depth, in double. Backends are compared with it. It does not use kernels/math: rotations are
// quaternion products, covariances are arrays, there are no tiles and no bounds. Source: method
// A.5, A.10, C.1–C.3, D.1.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "tests/support/brute_force_colour.h"
#include "tests/support/test_scene.h"

namespace tessera::testing {

using Quaternion = std::array<double, 4>;

inline Quaternion hamilton(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

inline Quaternion unit_quaternion(const double* q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

/// A Gaussian at a time: mean, 3×3 covariance, opacity after the marginal.
struct BruteGaussian {
  std::array<double, 3> mean{};
  double covariance[3][3] = {};
  double opacity = 0;
};

/// Σ₄ on (t, x, y, z) from its axes l·e_k·r, each of deviation e^{scale}; a static Gaussian is the
/// same with r = conj(l) and no time axis. With a velocity v, time's axis is σ_t (1, v). The 3D
/// filter widens the spatial deviations by φ, the temporal one σ_t² by f where a Gaussian fades.
inline BruteGaussian slice_brute(const TestGaussians<double>& set, int64_t n, double time,
                                 double time_filter = 0) {
  const Quaternion l = unit_quaternion(set.at(kRotation, n));
  const Quaternion r = set.form == SetForm::kPair ? unit_quaternion(set.at(kRotationRight, n))
                                                  : Quaternion{l[0], -l[1], -l[2], -l[3]};
  const double size = set.filter_size.empty() ? 0 : set.filter_size[size_t(n)];
  double S[4][4] = {}, compensation = 1;
  for (int k = set.form != SetForm::kStatic ? 0 : 1; k < 4; ++k) {
    Quaternion axis{};
    axis[size_t(k)] = std::exp(k == 0 ? *set.at(kLogScaleTime, n) : set.at(kLogScale, n)[k - 1]);
    if (k > 0 && size > 0) {
      const double wide = std::hypot(axis[size_t(k)], size);
      compensation *= axis[size_t(k)] / wide;
      axis[size_t(k)] = wide;
    }
    Quaternion image = hamilton(hamilton(l, axis), r);
    for (size_t i = 0; set.form == SetForm::kVelocity && k == 0 && i < 3; ++i)
      image[i + 1] = axis[0] * set.at(kVelocity, n)[i];
    for (size_t i = 0; i < 4; ++i)
      for (size_t j = 0; j < 4; ++j) S[i][j] += image[i] * image[j];
  }
  BruteGaussian g;
  g.opacity = compensation / (1 + std::exp(-*set.at(kOpacityLogit, n)));
  const double delta = set.form != SetForm::kStatic ? time - *set.at(kMeanTime, n) : 0;
  const double w = set.form != SetForm::kStatic ? S[0][0] : INFINITY;
  for (size_t i = 0; i < 3; ++i) {
    g.mean[i] = set.at(kMean, n)[i] + S[i + 1][0] * delta / w;
    for (size_t j = 0; j < 3; ++j)
      g.covariance[i][j] = S[i + 1][j + 1] - S[i + 1][0] * S[0][j + 1] / w;
  }
  const double marginal = std::exp(-delta * delta / (2 * (w + time_filter)));
  g.opacity *= marginal < 0.05 ? 0 : marginal;
  return g;
}

struct BruteSplat {
  double depth = 0, u = 0, v = 0, opacity = 0;
  double compensation = 1;  // of the 2D filter, in `opacity` already
  double conic_uu = 0, conic_uv = 0, conic_vv = 0;
  std::array<double, 3> colour{};
};

inline std::array<double, 3> colour_brute(const TestGaussians<double>& set, int64_t n,
                                          const std::array<double, 3>& mean, const View& view,
                                          const RenderOptions& options) {
  const glm::dvec3 eye = view.camera.position();
  double d[3], length = 0;
  for (int i = 0; i < 3; ++i) {
    d[i] = mean[size_t(i)] - eye[i];
    length += d[i] * d[i];
  }
  length = std::sqrt(length);
  const auto Y = published_sh_basis(d[0] / length, d[1] / length, d[2] / length);
  std::array<double, 3> colour{0.5, 0.5, 0.5};
  const int degree = options.sh_degree;
  const int bands = std::min((degree + 1) * (degree + 1), set.coefficients);
  for (int level = 0; level <= std::min(options.sh_time_degree, set.time_levels); ++level) {
    const double* const sh =
        level == 0 ? set.at(kSh, n) : set.at(kShTime, n) + (level - 1) * 3 * set.coefficients;
    double wave = 1;
    if (level > 0)
      wave =
          std::cos(2 * M_PI * level * (view.time - *set.at(kMeanTime, n)) / options.sh_time_period);
    for (int k = 0; k < bands; ++k)
      for (size_t c = 0; c < 3; ++c) colour[c] += wave * Y[size_t(k)] * sh[3 * k + int(c)];
  }
  for (double& c : colour) c = std::max(c, 0.0);
  return colour;
}

/// False when the Gaussian is not drawn in the view. `frozen`: a compensation instead of its own.
inline bool splat_brute(const TestGaussians<double>& set, int64_t n, const View& view,
                        const RenderOptions& options, BruteSplat& out,
                        const double* frozen = nullptr) {
  const BruteGaussian g = slice_brute(set, n, view.time, options.time_filter);
  if (g.opacity == 0 && !options.truncation_by_falloff) return false;
  const Camera& camera = view.camera;
  double W[3][3], p[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = camera.translation[i];
    for (int j = 0; j < 3; ++j) {
      W[i][j] = camera.cam_from_world[j][i];
      p[i] += W[i][j] * g.mean[size_t(j)];
    }
  }
  if (p[2] < options.near_plane || p[2] > options.far_plane) return false;
  const double x = std::clamp(p[0] / p[2], (-0.15 * camera.width - camera.cx) / camera.fl_x,
                              (1.15 * camera.width - camera.cx) / camera.fl_x);
  const double y = std::clamp(p[1] / p[2], (-0.15 * camera.height - camera.cy) / camera.fl_y,
                              (1.15 * camera.height - camera.cy) / camera.fl_y);
  const double J[2][3] = {{camera.fl_x / p[2], 0, -camera.fl_x * x / p[2]},
                          {0, camera.fl_y / p[2], -camera.fl_y * y / p[2]}};
  const double dilation = options.filter_2d ? 0.1 : 0.3;
  double A[2][3] = {}, cov[2][2] = {};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) A[i][j] += J[i][k] * W[k][j];
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 9; ++k)
        cov[i][j] += A[i][k / 3] * g.covariance[k / 3][k % 3] * A[j][k % 3];
  const double sharp = cov[0][0] * cov[1][1] - cov[0][1] * cov[1][0];
  cov[0][0] += dilation;
  cov[1][1] += dilation;
  const double det = cov[0][0] * cov[1][1] - cov[0][1] * cov[1][0];
  if (!(det >= 1e-6)) return false;
  out.compensation = !options.filter_2d ? 1
                     : frozen           ? *frozen
                                        : std::sqrt(std::max(0.0, sharp / det));
  out.depth = p[2];
  out.opacity = g.opacity * out.compensation;
  out.u = camera.fl_x * p[0] / p[2] + camera.cx;
  out.v = camera.fl_y * p[1] / p[2] + camera.cy;
  out.conic_uu = cov[1][1] / det;
  out.conic_uv = -cov[0][1] / det;
  out.conic_vv = cov[0][0] / det;
  out.colour = colour_brute(set, n, g.mean, view, options);
  return true;
}

/// One view; `critical` marks pixels where some α or the transmittance comes within the relative
/// `band` of its cut-off, so that rounding may decide otherwise there.
struct BruteImage {
  std::vector<double> colour, transmittance;  // [3, height, width], [height, width]
  std::vector<bool> critical;
};

/// `frozen`: the compensation of every Gaussian, those of the static set first.
inline BruteImage render_brute(const TestScene<double>& scene, const View& view, double band = 0,
                               const std::vector<double>& frozen = {}) {
  std::vector<BruteSplat> splats;
  BruteSplat splat;
  size_t number = 0;
  for (const TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (int64_t n = 0; n < set->count; ++n, ++number)
      if (splat_brute(*set, n, view, scene.options, splat,
                      frozen.empty() ? nullptr : &frozen[number]))
        splats.push_back(splat);
  const double k = scene.options.truncation_sigma, threshold = std::exp(-k * k / 2);
  // in steps of 16 units in the last place of a float, in which Gaussians keep their order
  const auto bits = [](double x) { return std::bit_cast<uint32_t>(float(x)); };
  const uint32_t nearest = bits(scene.options.near_plane);
  const auto step = [&](const BruteSplat& s) { return (bits(s.depth) - nearest) / 16; };
  std::stable_sort(splats.begin(), splats.end(),
                   [&](const BruteSplat& a, const BruteSplat& b) { return step(a) < step(b); });
  const int width = view.camera.width, pixels = width * view.camera.height;
  BruteImage image{std::vector<double>(size_t(3 * pixels)), std::vector<double>(size_t(pixels)),
                   std::vector<bool>(size_t(pixels))};
  for (int p = 0; p < pixels; ++p) {
    double T = 1, colour[3] = {};
    for (const BruteSplat& s : splats) {
      const double dx = s.u - (p % width + 0.5), dy = s.v - (p / width + 0.5);
      const double falloff =
          std::exp(-0.5 * (s.conic_uu * dx * dx + s.conic_vv * dy * dy) - s.conic_uv * dx * dy);
      const double alpha = s.opacity * falloff;
      const double cut = scene.options.truncation_by_falloff ? falloff : alpha;
      if (std::abs(cut / threshold - 1) < band) image.critical[size_t(p)] = true;
      if (cut < threshold) continue;
      for (size_t c = 0; c < 3; ++c) colour[c] += T * alpha * s.colour[c];
      T *= 1 - alpha;
      if (std::abs(1e4 * T - 1) < band) image.critical[size_t(p)] = true;
      if (T < 1e-4) break;
    }
    image.transmittance[size_t(p)] = T;
    for (int c = 0; c < 3; ++c)
      image.colour[size_t(c * pixels + p)] = colour[c] + T * scene.options.background[c];
  }
  return image;
}

}  // namespace tessera::testing
