// Fuzz target: colour profiles, alone and in PNG and JPEG files, on arbitrary bytes. See
// scripts/fuzz.sh.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "ingest/images/colour_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const tessera::StatedColour& stated :
       {tessera::colour_of_icc(bytes), tessera::colour_of_file(bytes)})
    if (stated.profile) {
      tessera::Image8 image{1, 1, 3, {1, 200, 99}};
      tessera::convert_to_srgb(*stated.profile, image);
    }
  return 0;
}
