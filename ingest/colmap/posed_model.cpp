// What: cameras.txt and images.txt with all digits of a double, and an empty points3D.txt.
// Not: numbers of images that fit a database: colmap goes by their names.
#include "ingest/colmap/posed_model.h"

#include <fmt/format.h>

#include <glm/gtc/quaternion.hpp>
#include <map>
#include <sstream>

#include "ingest/colmap/colmap_camera.h"
#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

double parameter_of(const RigCamera& rig, const std::string& name) {
  const Camera& camera = rig.camera;
  const Lens& lens = rig.lens;
  const std::map<std::string, double> values{
      {"f", camera.fl_x},   {"fx", camera.fl_x}, {"fy", camera.fl_y}, {"cx", camera.cx},
      {"cy", camera.cy},    {"k1", lens.k1},     {"k2", lens.k2},     {"k3", lens.k3},
      {"k4", lens.k4},      {"d1", lens.d1},     {"d2", lens.d2},     {"d3", lens.d3},
      {"p1", lens.p1},      {"p2", lens.p2},     {"s1", lens.s1},     {"s2", lens.s2},
      {"omega", lens.omega}};
  const auto found = values.find(name);
  check(found != values.end(), "a parameter of a COLMAP camera without a value");
  return found->second;
}

}  // namespace

std::string colmap_lens_line(const RigCamera& rig) {
  std::string line = fmt::format("{} {} {}", rig.lens_model, rig.camera.width, rig.camera.height);
  std::istringstream names(colmap_camera_model(rig.lens_model, rig.name).parameters);
  for (std::string name; names >> name;) line += fmt::format(" {:.17g}", parameter_of(rig, name));
  return line;
}

void write_posed_model(const std::filesystem::path& folder, const std::vector<PosedImage>& images) {
  std::map<std::string, size_t> ids;  // of lens lines
  std::string cameras, lines;
  for (size_t i = 0; i < images.size(); ++i) {
    const auto& [name, rig] = images[i];
    const auto [lens, is_new] = ids.insert({colmap_lens_line(rig), ids.size() + 1});
    if (is_new) cameras += fmt::format("{} {}\n", lens->second, lens->first);
    const glm::dquat q = glm::quat_cast(rig.camera.cam_from_world);
    const glm::dvec3& t = rig.camera.translation;
    lines += fmt::format("{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {} {}\n\n",
                         i + 1, q.w, q.x, q.y, q.z, t.x, t.y, t.z, lens->second, name);
  }
  make_folder(folder);
  write_text_file(folder / "cameras.txt", cameras);
  write_text_file(folder / "images.txt", lines);
  write_text_file(folder / "points3D.txt", "");
}

}  // namespace tessera
