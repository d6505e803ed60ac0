// What: cameras that are known → a COLMAP model of text files without points, for its programs to
//       start from.
// Not: the reader (colmap_model.h).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/poses/rig_camera.h"

namespace tessera {

struct PosedImage {
  std::string name;  // below the folder of the images
  RigCamera camera;
};

/// A camera as cameras.txt has it: "PINHOLE 480 360 400 400 240 180". Errors: InputError: a model's
/// name that COLMAP does not have.
std::string colmap_lens_line(const RigCamera& camera);

/// Images of equal lenses share one camera, so that what refines them keeps them equal. Errors:
/// InputError: the folder cannot be written, an unknown model's name.
void write_posed_model(const std::filesystem::path& folder, const std::vector<PosedImage>& images);

}  // namespace tessera
