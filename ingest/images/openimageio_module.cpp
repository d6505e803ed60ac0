// Finds the module in the folders of libraries that the program was linked with.
#include "ingest/images/openimageio_module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <stdexcept>

namespace tessera {
namespace {

using Read = void (*)(const std::filesystem::path& file, SourceImage& image, std::string& icc);

Read loaded() {
  void* const module = ::dlopen("libtessera_openimageio.so", RTLD_NOW | RTLD_LOCAL);
  void* const read = module == nullptr ? nullptr : ::dlsym(module, "tessera_read_image");
  if (read == nullptr)
    throw std::runtime_error(fmt::format(
        "images other than PNG cannot be read ({}); install the program again", ::dlerror()));
  return reinterpret_cast<Read>(read);
}

}  // namespace

SourceImage read_through_openimageio(const std::filesystem::path& file, std::string& icc) {
  static const Read read = loaded();
  SourceImage image;
  read(file, image, icc);
  return image;
}

}  // namespace tessera
