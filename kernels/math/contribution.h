// The contribution of one Gaussian to the images of a scoring pass, summed splat by splat: its
// blending weight, the squared error that its removal or simplification adds, and the part of the
// residual over it that changes with time. Source: docs/explanation/size.md.
#pragma once
#include "kernels/math/sensitivity.h"
#include "kernels/math/spherindrical.h"

namespace tessera {

/// Sums over the splats of a Gaussian; w = T·α, x: the image that is measured.
template <class Real>
struct ElementSums {
  Real weight, removal1, removal2, moving;  // as SplatSensitivity
  Vec3<Real> image;                         // Σ w·x
  Real time, opacity;                       // Σ w·t, Σ w·o of the effective opacity
  Real truncation[kMaxShDegree];            // [d] squared error added by the bands above degree d
};

/// Where a splat stands in a scoring pass. A series is drawn in the order of its timesteps, all of
/// them by the same cameras: what a camera misses in its own way does not look like a change there.
struct SeriesTime {
  int32_t series, timestep;  // each from 0 on; cameras of one timestep may differ in their time
  float time;
};

/// Of one Gaussian at one timestep of a series, summed over the cameras.
struct TimestepSums {
  Vec3<double> residual;  // Σ w·x
  Vec3<double> light;     // Σ w·c
  double weight2;         // Σ w²
};

/// Of one Gaussian in one series.
struct SeriesSums {
  Vec3<double> residual;  // Σ_t s_t
  double weight2;         // Σ_t W_t
  double gain;            // Σ_t |s_t|²/W_t
  float timesteps;        // at which it was seen
};

/// Sums over timesteps: the error that a colour of its own at every timestep takes away is
/// Σ_t |s_t|²/W_t, that one colour for all timesteps of a series does |Σ s_t|²/Σ W_t.
struct TimeVariation {
  SeriesTime last;        // of the splat that was added last
  TimestepSums timestep;  // that is not closed yet
  SeriesSums series;      // that is not closed yet
  double varying_gain;    // Σ over series of the difference
  double gain;            // Σ_t |s_t|²/W_t over all
  double light;           // squared error that its removal would add, by timestep
  double peak_gain;       // of the timestep with most of it
  Vec3<double> colour;    // to be added there
  float peak_time;        // when that is
  float timesteps;        // at which it was seen
  float freedom;          // Σ over series of the timesteps beyond the first
};

TESSERA_HD inline void close_timestep(TimeVariation& v) {
  const TimestepSums closed = v.timestep;
  v.timestep = {};
  if (!(closed.weight2 > 0)) return;
  const double gain = dot(closed.residual, closed.residual) / closed.weight2;
  v.gain += gain;
  v.timesteps += 1;
  v.series.gain += gain;
  v.series.residual += closed.residual;
  v.series.weight2 += closed.weight2;
  v.series.timesteps += 1;
  v.light += dot(closed.light, closed.light) / closed.weight2;
  if (!(gain > v.peak_gain)) return;
  v.peak_gain = gain;
  v.peak_time = v.last.time;
  v.colour = closed.residual * (-1 / closed.weight2);
}

/// Closes the timestep, too. What is added after it begins another series.
TESSERA_HD inline void close_series(TimeVariation& v) {
  close_timestep(v);
  const SeriesSums closed = v.series;
  v.series = {};
  if (!(closed.weight2 > 0)) return;
  v.varying_gain += closed.gain - dot(closed.residual, closed.residual) / closed.weight2;
  v.freedom += closed.timesteps - 1;
}

/// Closes what ended before `now`.
TESSERA_HD inline void advance(SeriesTime now, TimeVariation& v) {
  if (now.series != v.last.series)
    close_series(v);
  else if (now.timestep != v.last.timestep)
    close_timestep(v);
  v.last = now;
}

/// Without the bands above d the colour is less by δ_d = Σ Y_k c_k, so that Σ (x − w·δ)² grows by
/// Σ w² |δ|² − 2 ⟨Σ w·x, δ⟩. `Y`: basis at the splat's direction; `negative`: channels that are
/// clamped, which do not change; `truncation` is added to.
template <class Real>
TESSERA_HD inline void add_truncation_errors(int degree, const Real* Y, const Real* sh,
                                             uint32_t negative, const SplatSensitivity<Real>& sum,
                                             Real* truncation) {
  Vec3<Real> less(Real(0));
  for (int d = degree - 1; d >= 0; --d) {
    for (int j = sh_coefficients(d); j < sh_coefficients(d + 1); ++j)
      less += Y[j] * Vec3<Real>(sh[3 * j], sh[3 * j + 1], sh[3 * j + 2]);
    Vec3<Real> shown = less;
    for (int c = 0; c < 3; ++c)
      if (negative >> c & 1) shown[c] = Real(0);
    truncation[d] += sum.weight2 * dot(shown, shown) - Real(2) * dot(sum.image, shown);
  }
}

/// Pixel p of planar residuals [3, pixels]: its squared error less that before into the first
/// channel, zeros into the others.
template <class Real>
TESSERA_HD inline void write_added_squares(const Real* before, Real* residual, int64_t pixels,
                                           int64_t p) {
  Real added = Real(0);
  for (int c = 0; c < 3; ++c) {
    const Real was = before[c * pixels + p];
    Real& now = residual[c * pixels + p];
    added += now * now - was * was;
    now = Real(0);
  }
  residual[p] = added;
}

}  // namespace tessera
