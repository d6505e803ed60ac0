// Lines as the columns of a PLY element `vertex` under the names of a format.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/files/ply.h"
#include "recon4d/model/splat_columns.h"

namespace tessera {

/// "t_center" of a format, which is "mean_time" here (splat_columns of the form kVelocity); a name
/// that is the same in both need not be listed.
struct ForeignName {
  const char* theirs;
  const char* ours;
};

/// The columns of lines with K coefficients under the names of a format, in the order of
/// splat_columns.
std::vector<SplatColumn> line_columns(const std::vector<ForeignName>& names, int coefficients);

/// Values as the file has them. Errors: InputError: no element `vertex`, or a column that is
/// missing.
GaussianSet read_lines(const std::filesystem::path& path, const PlyFile& file,
                       const std::vector<ForeignName>& names);

/// One number of a comment. Errors: InputError: there is no such comment.
double required_number(const std::filesystem::path& path, const PlyFile& file,
                       const std::string& key);

}  // namespace tessera
