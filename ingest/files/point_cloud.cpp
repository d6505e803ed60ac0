// Converts PLY columns to a PointCloud and checks them. Columns of normals, confidences and faces
// are ignored.
#include "ingest/files/point_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/ply.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr std::array<uint8_t, 3> kGrey{128, 128, 128};  // of points without colours

/// Colour columns as 8 bit: integers as they are, floats as fractions of one.
std::array<uint8_t, 3> colour_at(const std::array<const PlyColumn*, 3>& columns, size_t row) {
  std::array<uint8_t, 3> colour = kGrey;
  for (size_t c = 0; c < 3; ++c) {
    if (columns[c] == nullptr) continue;
    const bool fraction =
        columns[c]->type == PlyType::kFloat32 || columns[c]->type == PlyType::kFloat64;
    const double value = columns[c]->values[row] * (fraction ? 255.0 : 1.0);
    colour[c] = uint8_t(std::lround(std::isfinite(value) ? std::clamp(value, 0.0, 255.0) : 0.0));
  }
  return colour;
}

/// The columns about time of the rows that were taken; a column without values is left empty.
void read_timesteps(const PlyElement& vertices, const std::vector<size_t>& rows,
                    const std::string& where, std::vector<std::string>& warnings,
                    PointCloud& points) {
  const PlyColumn *time = vertices.find("time"), *still = vertices.find("still");
  size_t outside = 0, known = 0;
  for (size_t row : rows) {
    if (time != nullptr) {
      const double value = time->values[row];
      const bool inside = value >= 0 && value <= 1;
      outside += !inside && !std::isnan(value);
      known += inside;
      points.time.push_back(inside ? float(value) : NAN);
    }
    if (still != nullptr)
      points.still.push_back(still->values[row] == 0   ? 0
                             : still->values[row] == 1 ? 1
                                                       : PointCloud::kStillUnknown);
  }
  if (known == 0) points.time.clear();
  if (outside > 0)
    warnings.push_back(
        fmt::format("{}: {} of {} points have times outside 0 to 1, which count as not known; "
                    "write times as fractions of the clip",
                    where, outside, rows.size()));
}

/// Velocities of the rows that were taken; one that is not finite is 0.
void read_velocities(const PlyElement& vertices, const std::vector<size_t>& rows,
                     PointCloud& points) {
  const std::array axes{vertices.find("vx"), vertices.find("vy"), vertices.find("vz")};
  if (axes[0] == nullptr || axes[1] == nullptr || axes[2] == nullptr) return;
  for (size_t row : rows) {
    const glm::vec3 velocity(axes[0]->values[row], axes[1]->values[row], axes[2]->values[row]);
    const bool finite =
        std::isfinite(velocity.x) && std::isfinite(velocity.y) && std::isfinite(velocity.z);
    points.velocity.push_back(finite ? velocity : glm::vec3(0));
  }
}

PointCloud read_points(const std::filesystem::path& path, const glm::dvec3& origin,
                       std::vector<std::string>& warnings) {
  const PlyFile file = read_ply(path);
  const PlyElement* vertices = file.find("vertex");
  const auto column = [&](const char* name) {
    return vertices == nullptr ? nullptr : vertices->find(name);
  };
  if (column("f_dc_0") != nullptr)
    throw InputError(fmt::format(
        "{}: is a 3D Gaussian model, expected a point cloud; name a cloud with x y z in "
        "ply_file_path, or remove this file",
        path.string()));
  const std::array axes{column("x"), column("y"), column("z")};
  if (axes[0] == nullptr || axes[1] == nullptr || axes[2] == nullptr)
    throw InputError(fmt::format(
        "{}: has no vertex columns x, y and z; name a point cloud in ply_file_path, or remove "
        "this file",
        path.string()));
  const std::array colours{column("red"), column("green"), column("blue")};
  PointCloud points;
  std::vector<size_t> taken;
  for (size_t row = 0; row < size_t(vertices->rows); ++row) {
    const glm::vec3 position(
        glm::dvec3(axes[0]->values[row], axes[1]->values[row], axes[2]->values[row]) - origin);
    if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z))
      continue;
    points.position.push_back(position);
    points.colour.push_back(colour_at(colours, row));
    taken.push_back(row);
  }
  read_timesteps(*vertices, taken, path.string(), warnings, points);
  read_velocities(*vertices, taken, points);
  const auto left_out = vertices->rows - int64_t(points.position.size());
  if (left_out > 0)
    warnings.push_back(fmt::format("{}: {} of {} points are not finite and were left out",
                                   path.string(), left_out, vertices->rows));
  return points;
}

}  // namespace

PointCloud find_points(const std::filesystem::path& folder, const std::string& stated,
                       std::vector<std::string>& warnings, const glm::dvec3& origin) {
  if (!stated.empty()) {
    if (std::filesystem::exists(folder / stated))
      return read_points(folder / stated, origin, warnings);
    warnings.push_back(
        fmt::format("{}: no such file; there is no initial cloud", (folder / stated).string()));
    return {};
  }
  for (const char* name : {"points.ply", "points3d.ply", "points3D.ply", "fused.ply"}) {
    if (!std::filesystem::is_regular_file(folder / name)) continue;
    try {
      return read_points(folder / name, origin, warnings);
    } catch (const InputError& error) {
      warnings.push_back(fmt::format("no initial cloud taken: {}", error.what()));
    }
  }
  return {};
}

void write_points(const std::filesystem::path& path, const PointCloud& points) {
  check(points.position.size() == points.colour.size(), "write_points: colours");
  check(points.time.empty() || points.time.size() == points.position.size(), "write_points: time");
  check(points.still.empty() || points.still.size() == points.position.size(),
        "write_points: still");
  check(points.velocity.empty() || points.velocity.size() == points.position.size(),
        "write_points: velocity");
  PlyElement vertices{"vertex", int64_t(points.position.size()), {}};
  for (const char* name : {"x", "y", "z"})
    vertices.columns.push_back({name, PlyType::kFloat32, {}});
  for (const char* name : {"red", "green", "blue"})
    vertices.columns.push_back({name, PlyType::kUint8, {}});
  for (size_t row = 0; row < points.position.size(); ++row)
    for (size_t c = 0; c < 3; ++c) {
      vertices.columns[c].values.push_back(points.position[row][glm::length_t(c)]);
      vertices.columns[3 + c].values.push_back(points.colour[row][c]);
    }
  if (!points.time.empty())
    vertices.columns.push_back(
        {"time", PlyType::kFloat32, {points.time.begin(), points.time.end()}});
  if (!points.still.empty())
    vertices.columns.push_back(
        {"still", PlyType::kUint8, {points.still.begin(), points.still.end()}});
  if (!points.velocity.empty()) {
    constexpr std::array kAxes{"vx", "vy", "vz"};
    for (glm::length_t c = 0; c < 3; ++c) {
      PlyColumn column{kAxes[size_t(c)], PlyType::kFloat32, {}};
      for (const glm::vec3& velocity : points.velocity) column.values.push_back(velocity[c]);
      vertices.columns.push_back(std::move(column));
    }
  }
  write_ply(path, {{}, {std::move(vertices)}});
}

void add_points(PointCloud& cloud, const PointCloud& more) {
  const size_t before = cloud.position.size(), after = before + more.position.size();
  const auto join = [&](auto& column, const auto& added, auto unknown) {
    if (column.empty() && added.empty()) return;
    column.resize(before, unknown);
    column.insert(column.end(), added.begin(), added.end());
    column.resize(after, unknown);
  };
  join(cloud.time, more.time, NAN);
  join(cloud.still, more.still, PointCloud::kStillUnknown);
  join(cloud.velocity, more.velocity, glm::vec3(0));
  cloud.position.insert(cloud.position.end(), more.position.begin(), more.position.end());
  cloud.colour.insert(cloud.colour.end(), more.colour.begin(), more.colour.end());
}

void move_points(const Similarity& b_from_a, PointCloud& cloud) {
  if (b_from_a.is_identity()) return;
  for (glm::vec3& position : cloud.position) position = glm::vec3(b_from_a(glm::dvec3(position)));
  for (glm::vec3& velocity : cloud.velocity)
    velocity = glm::vec3(b_from_a.scale * (b_from_a.rotation * glm::dvec3(velocity)));
}

void change_time_axis(PointCloud& cloud, const TimeAxis& from, const TimeAxis& to) {
  for (float& time : cloud.time) {
    const double moved = (from.origin + from.duration * double(time) - to.origin) / to.duration;
    time = moved >= -1e-6 && moved <= 1 + 1e-6 ? float(std::clamp(moved, 0.0, 1.0)) : NAN;
  }
  for (glm::vec3& velocity : cloud.velocity) velocity *= float(to.duration / from.duration);
}

}  // namespace tessera
