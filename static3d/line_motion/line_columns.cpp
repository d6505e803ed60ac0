// Renames the columns of a set of lines.
#include "static3d/line_motion/line_columns.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"

namespace tessera {

std::vector<SplatColumn> line_columns(const std::vector<ForeignName>& names, int coefficients) {
  std::vector<SplatColumn> columns = splat_columns(SetForm::kVelocity, coefficients);
  for (SplatColumn& column : columns)
    for (const ForeignName& name : names)
      if (column.name == name.ours) {
        column.name = name.theirs;
        break;
      }
  return columns;
}

GaussianSet read_lines(const std::filesystem::path& path, const PlyFile& file,
                       const std::vector<ForeignName>& names) {
  const PlyElement* const vertex = file.find("vertex");
  if (vertex == nullptr)
    throw InputError(fmt::format("{}: no element 'vertex'; export it again", path.string()));
  const int coefficients = stored_coefficients(path, *vertex);
  return read_columns(path, *vertex, line_columns(names, coefficients), SetForm::kVelocity,
                      coefficients);
}

double required_number(const std::filesystem::path& path, const PlyFile& file,
                       const std::string& key) {
  const std::vector<double> number = comment_numbers(path, file.comments, key, 1);
  if (number.empty())
    throw InputError(fmt::format("{}: no comment '{}'; export it again", path.string(), key));
  return number[0];
}

}  // namespace tessera
