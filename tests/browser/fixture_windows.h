// A Tessera 4D file of two windows for readers, and what the program finds in it at some times.
#pragma once
#include <filesystem>

#include "recon4d/model/gaussian_set.h"

namespace tessera::testing {

/// Writes few_windows.t4d and, for each time of tests/docs/make_vectors.py, the Gaussians that are
/// drawn as a 3DGS file: few_windows_0000.ply. The windows have the dynamic Gaussians of one model
/// each.
void write_windows(const std::filesystem::path& folder, const GaussianModel& first,
                   const GaussianModel& second);

}  // namespace tessera::testing
