// A GaussianModel as a Tessera .ply file, which reloads bit-equal. It has no optimizer state
// (checkpoint.h), and differs from the 3DGS .ply of other programs
// (static3d/formats/splat_formats.h).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/files/ply.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/model/splat_columns.h"

namespace tessera {

/// Elements `vertex` (static set, standard 3DGS columns) and `vertex_dynamic` (the same plus
/// mean_time, scale_time, rot_right_0..3 or velocity_0..2, and f_cos1_*, f_cos2_* where colours
/// follow time); stored parameters unchanged; comments carry the version, time axis,
/// background, train_scale, prepared_from_source and each drawing rule by its name; with an
/// environment also an element of that name, one row a texel. Written atomically.
void save_model(const std::filesystem::path& path, const GaussianModel& model);
/// Errors: InputError naming the file and what is missing. `is_tessera_model` tests for it
/// beforehand.
GaussianModel load_model(const std::filesystem::path& path);
/// Whether the .ply carries Tessera's comment (a plain 3DGS .ply does not).
bool is_tessera_model(const std::filesystem::path& path);

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
