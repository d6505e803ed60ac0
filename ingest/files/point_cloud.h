// Finds, reads, checks and writes the initial cloud of a capture. A 3DGS .ply is refused.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

/// The cloud that `stated` names (relative to `folder`), or, where it is empty, one of points.ply,
/// points3d.ply, points3D.ply, fused.ply if there is one; positions less `origin`, which is
/// subtracted in double. Points that are not finite are left out
/// with a warning, times outside [0, 1] count as not known, also with one; a cloud that was found
/// but is no cloud is passed over with a warning. Errors: InputError: a stated file that is
/// missing, no PLY, without x y z, or a 3DGS model.
PointCloud find_points(const std::filesystem::path& folder, const std::string& stated,
                       std::vector<std::string>& warnings, const glm::dvec3& origin = {});

/// x y z float, red green blue uchar; and, where the cloud has them, time float (normalised over
/// the whole scene, NaN: not known), still uchar (1, 0, other: not known) and vx vy vz float (world
/// units per unit of normalised time). Errors: InputError when it cannot be written.
void write_points(const std::filesystem::path& path, const PointCloud& points);

/// Appends `more`; a column that only one of them has is filled up with "not known", a velocity
/// with 0.
void add_points(PointCloud& cloud, const PointCloud& more);
/// Positions and velocities in another world.
void move_points(const Similarity& b_from_a, PointCloud& cloud);

/// States the times and velocities of `cloud` on another axis; times that lie outside it become
/// not known.
void change_time_axis(PointCloud& cloud, const TimeAxis& from, const TimeAxis& to);

}  // namespace tessera
