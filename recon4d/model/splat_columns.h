// A GaussianSet as the columns of a PLY element, in the order of the 3DGS reference code. Source:
// [3DGS] layout: normals zero, f_rest channel-major; Dim 4 adds its own groups.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/files/ply.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// One stored scalar of every Gaussian: its PLY name and its place in the set.
struct SplatColumn {
  std::string name;
  std::optional<Group> group;  // nothing: a normal, always zero
  int offset = 0;              // scalar inside a row of the group
};

/// x y z [nx ny nz] f_dc f_rest opacity scale rot, then for Dim 4 mean_time scale_time, by form
/// rot_right or velocity, of a canonical set node_0 … node_7 and node_logit_0 … node_logit_7, and
/// f_cos1_0 … f_cos<L>_<3K−1>, the levels of time, each channel-major. Normals belong to Dim 3
/// only, where viewers expect them.
std::vector<SplatColumn> splat_columns(SetForm form, int coefficients, int time_levels = 0);

/// The form that the columns of a dynamic element are of.
SetForm dynamic_form_of(const PlyElement& element);

/// A set as an element of a file; the first `coefficients` of its SH are written. All, where the
/// set has levels of time.
struct SplatElement {
  std::string name;
  const GaussianSet* set = nullptr;
  int coefficients = 0;
  std::vector<SplatColumn> columns{};  // of another program; empty: splat_columns
};

/// Rows of floats that are no Gaussians, after the sets in the file.
struct FloatElement {
  std::string name;
  std::vector<std::string> columns;
  Span<const float> values;  // [rows, columns]
};

/// [rows, columns] of an element. Errors: InputError naming a column that is missing.
std::vector<float> read_floats(const std::filesystem::path& path, const PlyElement& element,
                               const std::vector<std::string>& columns);

/// Values as stored, `float` columns, binary little-endian, atomically; needs no copy of the sets.
void write_splats(const std::filesystem::path& path, const std::vector<std::string>& comments,
                  const std::vector<SplatElement>& elements,
                  const std::vector<FloatElement>& others = {});

/// Rows of `element` as a set with the SH coefficients that its f_rest columns make: 1, 4, 9 or 16.
/// Every column but the normals is required, and f_cos of whole levels where there are any. Errors:
/// InputError naming `path`, the element and the property that is missing, or the count of f_rest
/// that fits no degree.
GaussianSet read_splats(const std::filesystem::path& path, const PlyElement& element, SetForm form);

/// The same with the columns of another program, for K coefficients; what has no column is 0.
GaussianSet read_columns(const std::filesystem::path& path, const PlyElement& element,
                         const std::vector<SplatColumn>& columns, SetForm form, int coefficients,
                         int time_levels = 0);

/// K by the number of f_rest columns: 1, 4, 9 or 16. Errors: InputError: that of no degree.
int stored_coefficients(const std::filesystem::path& path, const PlyElement& element);

}  // namespace tessera
