// Looks for the images of the model with the index that their reader uses.
#include "ingest/calibration/model_photos.h"

#include <algorithm>

#include "ingest/colmap/colmap_model.h"
#include "ingest/images/image_index.h"
#include "ingest/images/image_paths.h"
#include "kernels/base/errors.h"

namespace tessera {

namespace fs = std::filesystem;

std::vector<fs::path> photo_folders(const fs::path& capture) {
  std::vector<fs::path> folders, others;
  if (!images_in(capture).empty()) folders.push_back(capture);
  for (const auto& entry : fs::directory_iterator(capture)) {
    std::error_code unreachable;
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') || !entry.is_directory(unreachable)) continue;
    if (name.starts_with("images"))
      folders.push_back(entry.path());
    else if (name != "masks" && !images_in(entry.path()).empty())
      others.push_back(entry.path());
  }
  return folders.empty() && others.size() == 1 ? others : folders;
}

bool names_photos(const fs::path& model, const std::vector<fs::path>& folders) {
  try {
    const std::vector<ColmapPhoto> photos = read_colmap_model(model).photos;
    return std::any_of(folders.begin(), folders.end(), [&](const fs::path& folder) {
      ImageIndex images(folder);
      return std::any_of(photos.begin(), photos.end(), [&](const ColmapPhoto& photo) {
        return !images.find(photo.name).empty();
      });
    });
  } catch (const InputError&) {
    return true;
  }
}

}  // namespace tessera
