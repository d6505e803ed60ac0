// Adds one splat to the sums of its Gaussian.
#pragma once
#include "kernels/batch.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/contribution.h"

namespace tessera {

/// Splats come in the order of their views' series and timesteps. `variation`: of a static Gaussian
/// where it is asked for, else nullptr.
template <class Real>
TESSERA_HD inline void add_splat(const ViewArgs<Real>& view, const ColourRules<Real>& colours,
                                 Real time_filter, const GaussianState<Real>& g,
                                 const Splat<Real>& splat, const SplatSensitivity<Real>& sum,
                                 ElementSums<Real>& sums, TimeVariation* variation) {
  sums.image += sum.image;
  if (!(sum.weight > Real(0))) return;
  sums.weight += sum.weight;
  sums.removal1 += sum.removal1;
  sums.removal2 += sum.removal2;
  sums.moving += sum.moving;
  sums.time += sum.weight * view.time;
  sums.opacity += sum.weight * splat.opacity;
  if (variation != nullptr) {
    advance({view.series, view.timestep, float(view.time)}, *variation);
    variation->timestep.residual += Vec3<double>(sum.image);
    variation->timestep.light += Vec3<double>(splat.colour) * double(sum.weight);
    variation->timestep.weight2 += double(sum.weight2);
  }
  if (colours.degree == 0) return;
  const Slice<Real> slice = slice_in_view(view, g, time_filter);
  Real distance;
  const Vec3<Real> direction =
      view_direction(view, colours.sliced_direction ? slice.mean : g.mean, distance);
  Real Y[kMaxShCoefficients] = {}, room[3 * kMaxShCoefficients];
  sh_basis(colours.degree, direction, Y);
  add_truncation_errors(colours.degree, Y, sh_at(colours, g, colour_delta(view, g), room),
                        splat.negative, sum, sums.truncation);
}

}  // namespace tessera
