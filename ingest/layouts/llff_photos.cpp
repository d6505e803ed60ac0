// What: the pairing of rows and file names.
// Not: the rows (llff_poses.h).
#include "ingest/layouts/llff_photos.h"

#include <fmt/format.h>

#include "ingest/images/image_paths.h"
#include "ingest/poses/llff_poses.h"
#include "kernels/base/errors.h"

namespace tessera {

ColmapModel read_llff_photos(const std::filesystem::path& poses,
                             const std::filesystem::path& images) {
  const auto rows = read_llff_poses(poses);
  const auto files = images_in(images);
  if (rows.size() != files.size())
    throw InputError(fmt::format(
        "{}: has {} rows, {} has {} images; LLFF has one row an image in the order of their "
        "names: put back the missing ones or remove those without a pose",
        poses.string(), rows.size(), images.string(), files.size()));
  ColmapModel model;
  model.files = {poses};
  for (size_t i = 0; i < files.size(); ++i)
    model.photos.push_back({files[i].filename().string(), rows[i].camera, {}, "PINHOLE"});
  return model;
}

}  // namespace tessera
