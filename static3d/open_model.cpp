// What: the choice of the reader.
// Not: a reader.
#include "static3d/open_model.h"

#include "recon4d/model_file.h"
#include "static3d/ply_3dgs.h"

namespace tessera {

OpenedModel open_model(const std::filesystem::path& path) {
  OpenedModel opened;
  opened.is_tessera = is_tessera_model(path);
  if (opened.is_tessera) {
    opened.model = load_model(path);
    return opened;
  }
  Ply3dgs file = load_ply_3dgs(path);
  opened.model.static_set = std::move(file.set);
  opened.model.sh_degree = file.sh_degree;
  opened.warnings = std::move(file.warnings);
  return opened;
}

}  // namespace tessera
