// Parses --fps. Decimal fractions are refused, as the rates of cameras are fractions such as
// 30000/1001.
#include "tools/video/frame_rate.h"

#include <fmt/format.h>

#include <charconv>

#include "kernels/base/errors.h"

namespace tessera {

FrameRate parse_frame_rate(const std::string& command, const std::string& text) {
  constexpr int kMost = 1'000'000;
  FrameRate rate;
  const char* const end = text.data() + text.size();
  auto parsed = std::from_chars(text.data(), end, rate.numerator);
  if (parsed.ec == std::errc() && parsed.ptr != end && *parsed.ptr == '/')
    parsed = std::from_chars(parsed.ptr + 1, end, rate.denominator);
  if (parsed.ec != std::errc() || parsed.ptr != end)
    throw InputError(fmt::format(
        "{}: --fps is '{}'; give a whole number or a fraction like 30000/1001", command, text));
  for (const int part : {rate.numerator, rate.denominator})
    if (part < 1 || part > kMost)
      throw InputError(fmt::format("{}: --fps is '{}', expected more than 0 and at most {}",
                                   command, text, kMost));
  return rate;
}

}  // namespace tessera
