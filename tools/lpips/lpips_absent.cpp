// Replaces LPIPS in a build without OpenCV's dnn module: an error that names what to install.
#include <fmt/format.h>

#include "kernels/base/errors.h"
#include "tools/lpips/lpips.h"

namespace tessera {

struct Lpips::Network {};

Lpips::Lpips(const std::filesystem::path& file, bool) {
  throw InputError(fmt::format(
      "--lpips {}: this program was built without OpenCV, which runs the network; build "
      "it with OpenCV's dnn module (scripts/install_packages.sh, TESSERA_INGEST=ON)",
      file.string()));
}

Lpips::~Lpips() = default;

double Lpips::distance(const Image8&, const Image8&) {
  check(false, "Lpips: none was made");
  return 0;
}

}  // namespace tessera
