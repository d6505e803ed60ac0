// EWA projection of a 3D Gaussian to a 2D one in pixels, its gradient, and the norm of the
// screen-space gradient that density control uses. Source: [Zwicker01], [3DGS]; constants and
// gradient: method A.5, A.12, D.6.
#pragma once
#include "kernels/math/symmetric.h"

namespace tessera {

/// A view as kernels loop over it, in the kernel's precision. Pixel centres at +0.5.
template <class Real>
struct ViewArgs {
  Real fl_x, fl_y, cx, cy;  // pixels
  Mat3<Real> cam_from_world;
  Vec3<Real> translation;  // x_in_cam = cam_from_world·x + translation
  Vec3<Real> position;     // camera centre, world units
  Real time;               // normalised
  Real readout;            // Camera::readout
  int32_t timestep;        // number of the timestep, whatever the camera's clock
  int32_t series;          // that it belongs to (contribution.h)
  int width, height;       // pixels
  int tiles_x, tiles_y;    // tiles that cover the image
  int64_t first_tile;      // index of this view's first tile in the batch
  int64_t first_pixel;     // index of this view's first pixel in the batch

  bool operator==(const ViewArgs&) const = default;
};

/// Added to the diagonal of Σ2 so that a splat is at least about a pixel wide  [3DGS code].
template <class Real>
inline constexpr Real kDilation = Real(0.3);
/// The Jacobian is evaluated at most 15 % of the image outside of it  [method A.5].
template <class Real>
inline constexpr Real kJacobianMargin = Real(0.15);
/// Smaller determinants of Σ2 are rejected  [method A.5].
template <class Real>
inline constexpr Real kMinDeterminant = Real(1e-6);

template <class Real>
struct Projection {
  Vec3<Real> in_cam;  // mean in camera space
  Vec2<Real> mean2d;  // pixels
  Sym2<Real> cov2d;   // Σ2 with dilation, pixels²
  Sym2<Real> conic;   // its inverse
  Real det;           // its determinant
};

/// The affine map J·W (rows a0, a1) and what its gradient needs.
template <class Real>
struct EwaFrame {
  Real x, y, z_inv;           // x/z, y/z, 1/z
  Real x_clamped, y_clamped;  // inside the margin
  Vec3<Real> a0, a1;          // rows of A = J·W
};

template <class Real>
TESSERA_HD inline EwaFrame<Real> ewa_frame(const ViewArgs<Real>& view, const Vec3<Real>& in_cam) {
  EwaFrame<Real> f;
  f.z_inv = Real(1) / in_cam[2];
  f.x = in_cam[0] * f.z_inv;
  f.y = in_cam[1] * f.z_inv;
  const Real mx = kJacobianMargin<Real> * Real(view.width);
  const Real my = kJacobianMargin<Real> * Real(view.height);
  f.x_clamped =
      clamp_to(f.x, (-mx - view.cx) / view.fl_x, (Real(view.width) + mx - view.cx) / view.fl_x);
  f.y_clamped =
      clamp_to(f.y, (-my - view.cy) / view.fl_y, (Real(view.height) + my - view.cy) / view.fl_y);
  const Vec3<Real> w0 = row(view.cam_from_world, 0), w1 = row(view.cam_from_world, 1),
                   w2 = row(view.cam_from_world, 2);
  f.a0 = (w0 - w2 * f.x_clamped) * (view.fl_x * f.z_inv);
  f.a1 = (w1 - w2 * f.y_clamped) * (view.fl_y * f.z_inv);
  return f;
}

template <class Real>
TESSERA_HD inline Vec3<Real> to_camera(const ViewArgs<Real>& view, const Vec3<Real>& mean) {
  return view.cam_from_world * mean + view.translation;
}

/// False when Σ2 is degenerate. `in_cam` must lie in front of the near plane.
template <class Real>
TESSERA_HD inline bool project_ewa(const ViewArgs<Real>& view, const Vec3<Real>& in_cam,
                                   const Sym3<Real>& covariance, Real dilation,
                                   Projection<Real>& out) {
  const EwaFrame<Real> f = ewa_frame(view, in_cam);
  out.in_cam = in_cam;
  out.mean2d = Vec2<Real>(view.fl_x * f.x + view.cx, view.fl_y * f.y + view.cy);
  const Vec3<Real> s0 = covariance * f.a0, s1 = covariance * f.a1;
  out.cov2d = {dot(f.a0, s0) + dilation, dot(f.a0, s1), dot(f.a1, s1) + dilation};
  out.det = out.cov2d.xx * out.cov2d.yy - out.cov2d.xy * out.cov2d.xy;
  // Also NaN; and Σ_c = S − w·v·vᵀ of a very fast Gaussian may round to an indefinite matrix.
  if (!(out.det >= kMinDeterminant<Real> && out.cov2d.xx > Real(0))) return false;
  const Real inverse = Real(1) / out.det;
  out.conic = {out.cov2d.yy * inverse, -out.cov2d.xy * inverse, out.cov2d.xx * inverse};
  return true;
}

/// dL/dΣ2 = −conic·G·conic  (symmetric convention).
template <class Real>
TESSERA_HD inline Sym2<Real> conic_backward(const Sym2<Real>& conic, const Sym2<Real>& d_conic) {
  const Real A = conic.xx, B = conic.xy, C = conic.yy;
  const Real gA = d_conic.xx, gB = d_conic.xy, gC = d_conic.yy;
  return {-(A * A * gA + Real(2) * A * B * gB + B * B * gC),
          -(A * B * gA + (A * C + B * B) * gB + B * C * gC),
          -(B * B * gA + Real(2) * B * C * gB + C * C * gC)};
}

/// d_mean (world) and d_covariance (symmetric convention) are added to.
template <class Real>
TESSERA_HD inline void project_ewa_backward(const ViewArgs<Real>& view, const Vec3<Real>& in_cam,
                                            const Sym3<Real>& covariance, const Sym2<Real>& conic,
                                            const Vec2<Real>& d_mean2d, const Sym2<Real>& d_conic,
                                            Vec3<Real>& d_mean, Sym3<Real>& d_covariance) {
  const EwaFrame<Real> f = ewa_frame(view, in_cam);
  const Sym2<Real> g = conic_backward(conic, d_conic);
  // Σ2 = A Σ Aᵀ + κI:  dΣ = Aᵀ g A,  dA = 2 g A Σ
  d_covariance += g.xx * symmetric_outer(f.a0, f.a0);
  d_covariance += (Real(2) * g.xy) * symmetric_outer(f.a0, f.a1);
  d_covariance += g.yy * symmetric_outer(f.a1, f.a1);
  const Vec3<Real> s0 = covariance * f.a0, s1 = covariance * f.a1;
  const Vec3<Real> d_a0 = Real(2) * (s0 * g.xx + s1 * g.xy);
  const Vec3<Real> d_a1 = Real(2) * (s0 * g.xy + s1 * g.yy);
  const Vec3<Real> w0 = row(view.cam_from_world, 0), w1 = row(view.cam_from_world, 1),
                   w2 = row(view.cam_from_world, 2);
  const Real j1 = view.fl_x * f.z_inv, j2 = view.fl_y * f.z_inv;
  const Real dj11 = dot(w0, d_a0), dj13 = dot(w2, d_a0);
  const Real dj22 = dot(w1, d_a1), dj23 = dot(w2, d_a1);
  // inside the margin the clamped ratio moves with the mean (v = 1), outside it is a constant
  const Real vx = f.x == f.x_clamped ? Real(1) : Real(0);
  const Real vy = f.y == f.y_clamped ? Real(1) : Real(0);
  const Real dX = j1 * d_mean2d[0] - vx * j1 * dj13 * f.z_inv;
  const Real dY = j2 * d_mean2d[1] - vy * j2 * dj23 * f.z_inv;
  const Real dZ = -j1 * f.x * d_mean2d[0] - j2 * f.y * d_mean2d[1] +
                  (j1 * ((vx * f.x + f.x_clamped) * dj13 - dj11) +
                   j2 * ((vy * f.y + f.y_clamped) * dj23 - dj22)) *
                      f.z_inv;
  d_mean += w0 * dX + w1 * dY + w2 * dZ;
}

/// ‖dL/d mean2D‖ of one splat in NDC, where the image is 2 wide and high; `d_mean2d` by pixels.
template <class Real>
TESSERA_HD inline Real ndc_gradient_norm(const Vec2<Real>& d_mean2d, int width, int height) {
  const Real x = d_mean2d[0] * Real(width) * Real(0.5);
  const Real y = d_mean2d[1] * Real(height) * Real(0.5);
  return sqrt(x * x + y * y);
}

/// Mean over the `seen` views of a batch of `views` that draw a Gaussian, of whose norms `sum` is
/// the sum. Each is that of the view's own loss, of which the batch's is the mean: times `views`.
template <class Real>
TESSERA_HD inline Real mean_view_norm(Real sum, int views, int seen) {
  return sum * Real(views) / Real(seen);
}

}  // namespace tessera
