// Writes the files of a COLMAP run, and runs the commands that static rigs and known poses share.
#include "ingest/colmap/colmap_workspace.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <sstream>

#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/colmap_records.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
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

ColmapWorkspace::ColmapWorkspace(const std::filesystem::path& work)
    : folder(std::filesystem::absolute(work)),
      images(folder / "pictures"),
      masks(folder / "masks"),
      database(folder / "database.db"),
      sparse(folder / "sparse") {
  make_folder(folder);
}

void ColmapWorkspace::clear() const {
  for (const char* name : {"key.txt", "pictures", "masks", "database.db", "sparse", "refined",
                           "points", "database.db-shm", "database.db-wal"})
    std::filesystem::remove_all(folder / name);
}

std::string ColmapWorkspace::image_name(size_t index, const Image8& image) {
  return fmt::format("{}x{}/{:03}.png", image.width, image.height, index);
}

std::string ColmapWorkspace::add(size_t index, const StillImage& still) const {
  const std::string name = image_name(index, still.image);
  make_folder((images / name).parent_path());
  make_folder((masks / name).parent_path());
  write_png(images / name, still.image);
  write_png(masks / (name + ".png"), still.mask);
  return name;
}

void ColmapWorkspace::find_matches(const ColmapProgram& colmap, const FeatureOptions& options,
                                   size_t count) const {
  colmap.extract_features(
      {{"--database_path", database.string()},
       {"--image_path", images.string()},
       {"--ImageReader.mask_path", masks.string()},
       {"--ImageReader.camera_model", options.lens_model},
       {options.intrinsics_per_camera ? "--ImageReader.single_camera_per_image"
                                      : "--ImageReader.single_camera_per_folder",
        "1"}},
      int64_t(count));
  colmap.match_features("exhaustive_matcher", {{"--database_path", database.string()}});
}

void ColmapWorkspace::triangulate(const ColmapProgram& colmap, const std::filesystem::path& model,
                                  const std::filesystem::path& out, double max_error) const {
  const std::string error = fmt::format("{}", max_error);
  make_folder(out);
  // transitivity 1: a match counts between two images of the model only, not through a third
  colmap.run("point_triangulator",
             {{"--database_path", database.string()},
              {"--image_path", images.string()},
              {"--input_path", model.string()},
              {"--output_path", out.string()},
              {"--clear_points", "1"},
              {"--Mapper.tri_complete_max_transitivity", "1"},
              {"--Mapper.filter_max_reproj_error", error},
              {"--Mapper.tri_merge_max_reproj_error", error},
              {"--Mapper.tri_complete_max_reproj_error", error}},
             "colmap: triangulating points");
}

bool ColmapWorkspace::holds(const std::string& key) const {
  const auto file = folder / "key.txt";
  return std::filesystem::is_regular_file(file) && read_text_file(file) == key;
}

void ColmapWorkspace::store_key(const std::string& key) const {
  write_text_file(folder / "key.txt", key);
}

double tight_error(int width) {
  return std::max(1.0, width / 1000.0);
}

std::filesystem::path largest_colmap_model(const std::filesystem::path& sparse, size_t images,
                                           std::vector<std::string>& warnings) {
  struct Candidate {
    std::filesystem::path folder;
    size_t images = 0;
  };
  std::vector<Candidate> candidates;
  if (std::filesystem::is_directory(sparse))
    for (const auto& entry : std::filesystem::directory_iterator(sparse))
      if (std::filesystem::exists(entry.path() / "cameras.bin") ||
          std::filesystem::exists(entry.path() / "cameras.txt"))
        candidates.push_back({entry.path(), read_colmap_model(entry.path()).photos.size()});
  if (candidates.empty()) return {};
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.images != b.images ? a.images > b.images : a.folder < b.folder;
  });
  if (candidates.size() > 1 && candidates[0].images < images)
    warnings.push_back(fmt::format(
        "COLMAP made {} models that do not fit together; the largest is used, with {} of {} images",
        candidates.size(), candidates[0].images, images));
  return candidates[0].folder;
}

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
