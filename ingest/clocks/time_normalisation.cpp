// What: the affine map of source times to [0, 1].
// Not: in float anywhere: at epoch seconds (1.7e9) a float steps by 128 s.
#include "ingest/clocks/time_normalisation.h"

#include <fmt/format.h>

#include <algorithm>

#include "kernels/base/errors.h"

namespace tessera {

NormalisedTimes normalise_times(const std::vector<double>& source_times, bool allow_static,
                                const std::string& where) {
  check(!source_times.empty(), "normalise_times of nothing");
  const auto [least, most] = std::minmax_element(source_times.begin(), source_times.end());
  NormalisedTimes result;
  result.axis.origin = *least;
  result.time.assign(source_times.size(), 0.0);
  if (*least == *most) {
    if (source_times.size() > 1 && !allow_static)
      throw InputError(fmt::format(
          "{}: all {} frames have time {}; pass --static to reconstruct one timestep, or correct "
          "the times",
          where, source_times.size(), *least));
    result.is_static = true;
    return result;
  }
  result.axis.duration = *most - *least;
  for (size_t i = 0; i < source_times.size(); ++i)
    result.time[i] = (source_times[i] - *least) / result.axis.duration;
  return result;
}

}  // namespace tessera
