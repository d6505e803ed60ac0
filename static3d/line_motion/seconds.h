// Lines between normalised time, with ln σ_t, and seconds of the clip, with σ_t itself, which
// .sogst and its PLY have.
#pragma once
#include <string>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

void to_seconds(const TimeAxis& axis, GaussianSet& lines);
/// Errors: InputError that begins with `where`: a clip without seconds, an extent not above 0.
void from_seconds(const std::string& where, const TimeAxis& axis, GaussianSet& lines);

}  // namespace tessera
