// The glTF 2.0 binary file of one static set: one mesh with KHR_gaussian_splatting under one node.
#include "static3d/formats/glb_file.h"
#include "static3d/formats/splat_formats.h"

namespace tessera {

void save_glb(const std::filesystem::path& path, const GaussianSet& set, int sh_degree) {
  GlbFile file;
  file.add_node({{"mesh", file.add_mesh(set, sh_degree)}});
  file.save(path);
}

}  // namespace tessera
