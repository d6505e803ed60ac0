// Motion nodes as elements of a Tessera 4D .ply: rows of nodes at rest and rows of their control
// points, beside the bindings that are columns of the Gaussians.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/files/ply.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/model/splat_columns.h"

namespace tessera {

/// Values in the order of the file; the elements point into it.
struct NodeElements {
  std::vector<float> at_rest;   // [M, 4] position, ln of the radius
  std::vector<float> controls;  // [M, S, 7] translation, rotation w,x,y,z

  explicit NodeElements(const MotionNodes& nodes);
  std::vector<FloatElement> elements() const;
};

/// The nodes of a file that has `count` of them with `knots` control points. Errors: InputError:
/// numbers that no model has, or elements with other rows or columns.
MotionNodes read_nodes(const std::filesystem::path& path, const PlyFile& file, double count,
                       double knots);

/// Bindings that are no numbers of `nodes` nodes. Errors: InputError.
void check_bindings(const std::filesystem::path& path, const GaussianSet& set, int64_t nodes);

}  // namespace tessera
