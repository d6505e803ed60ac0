// What: the SH degree of each Gaussian of a training: rows sorted into blocks of one degree, rows
//       kept, rows added, and the way back to a set whose rows are alike. On any backend.
// Not: which degree a Gaussian deserves. Nothing outside a TrainState sees blocks: every model that
//      leaves it is padded.
#pragma once
#include <vector>

#include "recon4d/model/set_statistics.h"

namespace tessera {

// Density control and relocation want sets whose rows are alike: degrees are decided when growth
// has ended.

/// SH degree of each row in storage order, [N].
std::vector<uint8_t> sh_degrees(const GaussianSet& set);

/// Row n gets the degree degrees[n]: higher bands are dropped, in all levels of time, and rows are
/// sorted, stably, into blocks. Moments and statistics move along; the anchor is forgotten.
/// Returns the row that each row was, [N]. Errors: std::logic_error: a degree above the row's own.
std::vector<int64_t> set_sh_degrees(Backend& backend, const std::vector<uint8_t>& degrees,
                                    GaussianSet& set, SetStatistics& statistics);

/// The rows `rows`, ascending, are left, with their moments and statistics. Errors:
/// std::logic_error where they do not ascend or there is no such row.
void keep_rows(Backend& backend, const std::vector<int64_t>& rows, GaussianSet& set,
               SetStatistics& statistics);

/// Adds the rows of `from`, a set of the same form, K and L in the same memory, with their
/// statistics. They stand behind those of their degree, and their moments are 0.
/// Returns the row that each row was, [N]: of `to`, or, from to's N on, of `from`.
std::vector<int64_t> append_rows(Backend& backend, const GaussianSet& from,
                                 const SetStatistics& from_statistics, GaussianSet& to,
                                 SetStatistics& statistics);

/// The same Gaussians in rows that are alike, K coefficients each: bands that a row does not have
/// are zeros, in the moments too. Of a set in the host's memory; the order of rows stays.
GaussianSet padded(const GaussianSet& set);

}  // namespace tessera
