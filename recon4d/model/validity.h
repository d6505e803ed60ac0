// What: which Gaussians are fit to leave the program: finite, with rotations of some length.
// Not: pruning by importance (density.h); nothing here looks at an image.
// Source: failure modes C5, E3.
#pragma once
#include <vector>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Whether every stored value of Gaussian n is finite and its quaternions are rotations.
bool is_valid_element(const GaussianSpans<const float>& set, int64_t n);
/// Indices of the sound Gaussians, ascending.
std::vector<int64_t> valid_elements(const GaussianSet& set);
/// The Gaussians at `elements`, in that order, without moments.
GaussianSet select_elements(const GaussianSet& set, const std::vector<int64_t>& elements);

}  // namespace tessera
