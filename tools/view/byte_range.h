// The `Range` header of a request for a part of a file [RFC 9110, section 14].
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace tessera {

struct ByteRange {
  uint64_t offset = 0, bytes = 0;
};

/// Whether the header counts in bytes. Other units are ignored, as RFC 9110 requires.
bool is_byte_range(std::string_view header);

/// The part of a file of `size` bytes that `header` names. A last byte behind the end is moved to
/// the end. Nothing, which is answered with 416: several ranges, a reversed range, one behind the
/// end, numbers of more than 18 digits, and all that is no range; RFC 9110 allows to reject these.
std::optional<ByteRange> parse_byte_range(std::string_view header, uint64_t size);

}  // namespace tessera
