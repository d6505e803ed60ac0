// A model moved to another world by a similarity; its images equal those of cameras that are moved
// in its place. Exports use it to return to the world of the source, and formats flip the signs of
// axes. Source: μ' = s·R·μ + t. A rotation q of space turns x ↦ l·x·r into (q·l)·x·(r·q̄), time
// being the real axis. A scale of space alone is no scale of a moving Gaussian's axes, which mix
// space and time: Σ₄' = D Σ₄ D, D = diag(1, s, s, s), is decomposed by one-sided Jacobi rotations
// of D·R₄·diag(σ) [GolubVanLoan]; where the axes do not mix, ln s is added. Signs of axes: formats
// 1.10.
#pragma once
#include "kernels/base/similarity.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Signs of x, y and z, of which an even number are −1.
struct AxisSigns {
  float x, y, z;
};
inline constexpr AxisSigns kAsIs{1, 1, 1};
inline constexpr AxisSigns kRightUpBack{1, -1, -1};  // SPZ, three.js, of right-down-front
inline constexpr AxisSigns kLeftUpFront{-1, -1, 1};  // glTF as viewers have it

/// Means, quaternions, velocities and SH in the flipped world; its own inverse. Not of a pair.
void flip_axes(GaussianSet& set, const AxisSigns& signs);

/// Values in another world; spherical harmonics turn along, opacities, timesteps of life and their
/// lengths stay, clip planes scale. Without optimizer state. The identity leaves every bit.
GaussianModel model_in_world(const Similarity& b_from_a, const GaussianModel& model);

/// The model in the world of its capture's source. Where that lies too far from its origin for
/// floats, less a far_origin(), which prepared_from_source takes out then; else that is the
/// identity.
GaussianModel model_in_source_world(const GaussianModel& model);

}  // namespace tessera
