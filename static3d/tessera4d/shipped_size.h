// What: how large a model is as it is shipped: the single Tessera 4D file.
// Not: the file itself (tessera4d/tessera4d.h).
#pragma once
#include "static3d/tessera4d/size_breakdown.h"

namespace tessera {

struct ShippedSize {
  int64_t bytes = 0;      // of the file
  SizeBreakdown account;  // which adds up to `bytes`
};

/// Of the single file that export would write with these options, encoded in memory; what the
/// format leaves out (never drawn, not finite) costs nothing. The defaults are those of `tessera
/// export`, but for the rig's cameras and its frame rate, which only the caller knows: about 200
/// bytes a camera. Cost: three seconds of one core for 100,000 Gaussians. Errors: as
/// encode_tessera4d.
ShippedSize shipped_size(const GaussianModel& model, const Tessera4dOptions& options = {});

}  // namespace tessera
