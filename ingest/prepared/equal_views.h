// Which frames of a transforms file are seen from one view: one pose, one set of intrinsics and one
// lens.
#pragma once
#include <vector>

#include "ingest/prepared/transforms_json.h"

namespace tessera {

/// The number of each frame's view, from 0 on in the order of the frames' names; as many as
/// `frames`. Views are equal within the noise of single precision: rotations and intrinsics within
/// 1e-5, centres within 1e-5 of the box that holds all of them, so the unit of the world does not
/// matter. Lenses are equal to the bit.
std::vector<int> view_numbers(const std::vector<TransformsFrame>& frames);

}  // namespace tessera
