// Frames per second as a fraction, and its text form.
#pragma once
#include <string>

namespace tessera {

/// 24/1, 30000/1001.
struct FrameRate {
  int numerator = 24, denominator = 1;

  double value() const { return double(numerator) / double(denominator); }
};

/// "24" or "30000/1001". Errors: InputError that begins with `command` and names --fps: no such
/// form, not positive, more than a million above or below the line.
FrameRate parse_frame_rate(const std::string& command, const std::string& text);

}  // namespace tessera
