// Conversion between Tessera's pairs of quaternions and those of the published 4D kernels.
#pragma once
#include "kernels/math/rotation4.h"

namespace tessera::testing {

/// Our (l, r) on (t, x, y, z) ↔ the published kernels' (l', r') on (x, y, z, t), both L·Q:
/// with P the cyclic re-ordering, P x = u·conj(x)·v for u = (i+k)/√2, v = (1+j)/√2, so
/// l' = u·conj(r)·conj(u) and r' = conj(v)·conj(l)·v: a signed permutation of the components.
template <class Real>
inline void published_from_ours(const Vec4<Real>& l, const Vec4<Real>& r, Vec4<Real>& published_l,
                                Vec4<Real>& published_r) {
  published_l = Vec4<Real>(r[0], -r[3], r[2], -r[1]);
  published_r = Vec4<Real>(l[0], l[3], -l[2], -l[1]);
}
template <class Real>
inline void ours_from_published(const Vec4<Real>& published_l, const Vec4<Real>& published_r,
                                Vec4<Real>& l, Vec4<Real>& r) {
  l = Vec4<Real>(published_r[0], -published_r[3], -published_r[2], published_r[1]);
  r = Vec4<Real>(published_l[0], -published_l[3], published_l[2], -published_l[1]);
}

}  // namespace tessera::testing
