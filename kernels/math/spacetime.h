// A Gaussian in the form {Σ_c, v, μ_t, 1/σ_t²} that every view of a batch needs, and its slice at a
// time t. The stages after it do not depend on the dimension: a static Gaussian has v = 0 and
// 1/σ_t² = 0, so its slice is itself at any t without a branch. Source: [Yang24] Eqs. 8–10;
// gradient: method D.2, regrouped by {Σ_c, v, 1/w}.
#pragma once
#include "kernels/math/rotation3.h"
#include "kernels/math/rotation4.h"

namespace tessera {

/// Below this marginal a Gaussian is not drawn: p(t) < 0.05  [Yang24 code; method D.1].
template <class Real>
inline constexpr Real kMinMarginal = Real(0.05);

template <class Real>
struct Spacetime {
  Sym3<Real> covariance;  // Σ_c: conditional spatial covariance, the same at every t
  Vec3<Real> velocity{};  // v = b/w: world units per unit of normalised time
  Real mean_time{};       // μ_t
  Real precision_time{};  // 1/w, w = Σ_tt
};

/// Dim 3.
template <class Real>
TESSERA_HD inline Spacetime<Real> static_spacetime(const Vec4<Real>& q,
                                                   const Vec3<Real>& log_scale) {
  Spacetime<Real> s{};
  s.covariance = rotate_diagonal(rotation_matrix(q), variances(log_scale));
  return s;
}

template <class Real>
TESSERA_HD inline Vec4<Real> variances4(const Vec3<Real>& log_scale, Real log_scale_time) {
  const Vec3<Real> v = variances(log_scale);
  return Vec4<Real>(exp(Real(2) * log_scale_time), v[0], v[1], v[2]);
}

/// Σ₄ = R diag(v) Rᵀ, v = (e^{2 s̃_t}, e^{2 s̃}), conditioned on time; (t_k, x_k) is column k of R.
/// u_k = x_k − velocity·t_k, so that Σ_c = Σ_k v_k u_k u_kᵀ.
template <class Real>
struct Conditional {
  Real precision;       // 1/w, w = Σ_tt = Σ_k v_k t_k²
  Vec3<Real> velocity;  // b/w, b = Σ_xt
  Vec3<Real> u[4];
};

/// u_k = Σ_l v_l t_l (t_l x_k − t_k x_l)/w, in which the term l = k is absent: for a fast Gaussian
/// the differences x_k − velocity·t_k and S − b bᵀ/w would lose all their digits.
template <class Real>
TESSERA_HD inline Conditional<Real> condition_on_time(const Mat4<Real>& R, const Vec4<Real>& v) {
  Conditional<Real> c{};
  Vec3<Real> x[4], b(Real(0));
  Real w = Real(0);
  for (int k = 0; k < 4; ++k) {
    x[k] = Vec3<Real>(R.m[1][k], R.m[2][k], R.m[3][k]);
    w += v[k] * R.m[0][k] * R.m[0][k];
    b += v[k] * R.m[0][k] * x[k];
  }
  c.precision = Real(1) / w;
  c.velocity = b * c.precision;
  for (int k = 0; k < 4; ++k)
    for (int l = k + 1; l < 4; ++l) {
      const Real tk = R.m[0][k], tl = R.m[0][l];
      const Vec3<Real> minor = (tl * x[k] - tk * x[l]) * c.precision;
      c.u[k] += v[l] * tl * minor;
      c.u[l] -= v[k] * tk * minor;
    }
  return c;
}

/// Dim 4, `pair` parameterisation.  Σ_c = S − b bᵀ/w, v = b/w  [Yang24, Eq. 8].
template <class Real>
TESSERA_HD inline Spacetime<Real> pair_spacetime(const Vec4<Real>& l, const Vec4<Real>& r,
                                                 const Vec3<Real>& log_scale, Real log_scale_time,
                                                 Real mean_time) {
  const Vec4<Real> v = variances4(log_scale, log_scale_time);
  const Conditional<Real> c = condition_on_time(rotation4(l, r), v);
  Spacetime<Real> s;
  s.precision_time = c.precision;
  s.velocity = c.velocity;
  s.covariance = {};
  for (int k = 0; k < 4; ++k) s.covariance += v[k] * symmetric_outer(c.u[k], c.u[k]);
  s.mean_time = mean_time;
  return s;
}

/// Dim 4, `velocity` parameterisation: stored as the slice has it. σ_t = e^{log_scale_time}.
template <class Real>
TESSERA_HD inline Spacetime<Real> velocity_spacetime(const Vec4<Real>& q,
                                                     const Vec3<Real>& log_scale,
                                                     const Vec3<Real>& velocity,
                                                     Real log_scale_time, Real mean_time) {
  Spacetime<Real> s = static_spacetime(q, log_scale);
  s.velocity = velocity;
  s.precision_time = exp(Real(-2) * log_scale_time);
  s.mean_time = mean_time;
  return s;
}

/// One Gaussian at one time.
template <class Real>
struct Slice {
  Vec3<Real> mean;  // μ + v·Δ
  Real marginal;    // p = exp(−½ Δ²/(w + f)), un-normalised
  Real delta;       // Δ = t − μ_t
  Real kept;        // w/(w + f): what the temporal filter leaves of 1/w in p
};

/// `filter`: f, normalised time²: added to the variance w in p alone; v and Σ_c stay  [method D.1].
template <class Real>
TESSERA_HD inline Slice<Real> slice_at(const Vec3<Real>& mean, const Spacetime<Real>& s, Real t,
                                       Real filter = Real(0)) {
  const Real delta = t - s.mean_time;
  const Real kept = filter > Real(0) ? Real(1) / (Real(1) + filter * s.precision_time) : Real(1);
  return {mean + s.velocity * delta, exp(Real(-0.5) * delta * delta * (s.precision_time * kept)),
          delta, kept};
}

/// Gradient by the struct's fields, summed over the views of a batch.
template <class Real>
struct SpacetimeGradient {
  Sym3<Real> covariance{};
  Vec3<Real> velocity{};
  Real mean_time{};
  Real precision_time{};
};

/// Adds one view: d_mean = dL/d(sliced mean), d_marginal = dL/dp.
template <class Real>
TESSERA_HD inline void slice_backward(const Spacetime<Real>& s, const Slice<Real>& slice,
                                      const Vec3<Real>& d_mean, Real d_marginal,
                                      SpacetimeGradient<Real>& d) {
  d.velocity += d_mean * slice.delta;
  const Real ep = d_marginal * slice.marginal * slice.delta;
  d.mean_time += ep * (s.precision_time * slice.kept) - dot(d_mean, s.velocity);
  d.precision_time += Real(-0.5) * ep * slice.delta * (slice.kept * slice.kept);
}

template <class Real>
struct PairGradient {
  Vec4<Real> rotation_left{}, rotation_right{};
  Vec3<Real> log_scale{};
  Real log_scale_time{};
};

/// Through Σ_c, v, 1/w to the two quaternions and four log-scales. With H = dL/dΣ₄ (symmetric):
/// H_xx = G, H_xt = −G b/w + ½ d_v/w, H_tt = bᵀGb/w² − ⟨d_v,b⟩/w² − d_{1/w}/w², and its products
/// with the columns of R written by u_k, where the large parts have cancelled already.
template <class Real>
TESSERA_HD inline PairGradient<Real> pair_backward(const Vec4<Real>& l, const Vec4<Real>& r,
                                                   const Vec3<Real>& log_scale, Real log_scale_time,
                                                   const SpacetimeGradient<Real>& d) {
  const Mat4<Real> R = rotation4(l, r);
  const Vec4<Real> v4 = variances4(log_scale, log_scale_time);
  const Conditional<Real> c = condition_on_time(R, v4);
  const Real half_along = Real(0.5) * dot(d.velocity, c.velocity);
  Mat4<Real> d_R;
  Real d_log[4];
  for (int k = 0; k < 4; ++k) {
    const Vec3<Real>& u = c.u[k];
    const Vec3<Real> Gu = d.covariance * u;
    const Real pt = c.precision * R.m[0][k], du = dot(d.velocity, u);
    const Vec3<Real> space_rows = Gu + Real(0.5) * pt * d.velocity;
    const Real time_row = Real(0.5) * c.precision * du - dot(c.velocity, Gu) -
                          pt * (half_along + c.precision * d.precision_time);
    d_log[k] = Real(2) * v4[k] * (dot(u, Gu) + pt * du - pt * pt * d.precision_time);
    d_R.m[0][k] = Real(2) * v4[k] * time_row;
    for (int i = 0; i < 3; ++i) d_R.m[i + 1][k] = Real(2) * v4[k] * space_rows[i];
  }
  PairGradient<Real> g;
  rotation4_backward(l, r, d_R, g.rotation_left, g.rotation_right);
  g.log_scale_time = d_log[0];
  g.log_scale = Vec3<Real>(d_log[1], d_log[2], d_log[3]);
  return g;
}

}  // namespace tessera
