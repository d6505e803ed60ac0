// A stream of a block: numbers to words, byte planes and gzip, and back; and the streams that hold
// the SH degrees. Source: docs/reference/tessera4d.md, section 4.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/math/spherical_harmonics.h"
#include "static3d/tessera4d/manifest.h"

namespace tessera {

inline constexpr const char* kShNames[kMaxShDegree + 1] = {"colour", "sh1", "sh2", "sh3"};

/// Scalars of a degree, three channels; where they begin in a row.
inline int band_width(int degree) {
  return 3 * (2 * degree + 1);
}
inline int band_begin(int degree) {
  return degree == 0 ? 0 : 3 * sh_coefficients(degree - 1);
}

/// Numbers as they are stored, before bytes.
struct StreamWords {
  StreamInfo info;              // without offset and bytes
  std::vector<uint32_t> words;  // [components, count]

  uint32_t* component(int c) { return words.data() + int64_t(c) * info.count; }
  const uint32_t* component(int c) const { return words.data() + int64_t(c) * info.count; }
};

/// Values, [components, count], to the nearest multiples of `step`, with the fewest bytes that hold
/// their range. A step that needs more than 24 bits is made larger.
StreamWords quantised(std::string name, int components, const std::vector<float>& values,
                      double step, bool delta = false);
/// The same in steps of 1/255 from 0 to 1.
StreamWords bytes_of_unit(std::string name, const std::vector<float>& values);
/// The bits of the floats.
StreamWords as_floats(std::string name, int components, const std::vector<float>& values);

/// What a reader gets for Gaussian n.
float value_at(const StreamWords& stream, int component, int64_t n);

/// The bytes of the stream as a block holds them. `gzip_level`: 1 to 12.
std::string packed_stream(const StreamWords& stream, int gzip_level);
/// Errors: InputError naming `path`: damaged, or not as long as it should be.
StreamWords read_stream(std::string_view block, const StreamInfo& info,
                        const std::filesystem::path& path);

}  // namespace tessera
