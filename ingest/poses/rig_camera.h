// What: a physical camera of a rig: its name, its pose and its lens.
// Not: its images or its clock.
#pragma once
#include <string>

#include "ingest/poses/lens.h"
#include "kernels/base/camera.h"

namespace tessera {

struct RigCamera {
  std::string name;                    // "cam02": the name of its video without extension
  Camera camera;                       // size and intrinsics of the upright image, and its pose
  Lens lens;                           // what the image has beyond the pinhole
  std::string lens_model = "PINHOLE";  // COLMAP's name of it
};

}  // namespace tessera
