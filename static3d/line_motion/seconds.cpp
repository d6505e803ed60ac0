// In place: the groups kMeanTime, kLogScaleTime and kVelocity change their units.
#include "static3d/line_motion/seconds.h"

#include <fmt/format.h>

#include <cmath>

#include "kernels/base/errors.h"

namespace tessera {

void to_seconds(const TimeAxis& axis, GaussianSet& lines) {
  const GaussianSpans<float> values = lines.values();
  for (int64_t n = 0; n < lines.count(); ++n) {
    float& time = *values.at(kMeanTime, n);
    float& extent = *values.at(kLogScaleTime, n);
    time = float(axis.origin + axis.duration * double(time));
    extent = float(axis.duration * std::exp(double(extent)));
    for (int k = 0; k < 3; ++k) values.at(kVelocity, n)[k] /= float(axis.duration);
  }
}

void from_seconds(const std::string& where, const TimeAxis& axis, GaussianSet& lines) {
  if (!(axis.duration > 0))
    throw InputError(fmt::format("{}: its clip ends at {} s, where it begins; export it again",
                                 where, axis.origin));
  const GaussianSpans<float> values = lines.values();
  for (int64_t n = 0; n < lines.count(); ++n) {
    float& time = *values.at(kMeanTime, n);
    float& extent = *values.at(kLogScaleTime, n);
    if (!(extent > 0))
      throw InputError(
          fmt::format("{}: a temporal deviation is {} s, expected more than 0; export it again",
                      where, extent));
    time = float((double(time) - axis.origin) / axis.duration);
    extent = float(std::log(double(extent) / axis.duration));
    for (int k = 0; k < 3; ++k) values.at(kVelocity, n)[k] *= float(axis.duration);
  }
}

}  // namespace tessera
