// What: the lookup of held-out names, and the count of every Nth.
// Not: a pattern match: names are whole.
#include "ingest/held_out_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "kernels/base/errors.h"

namespace tessera {

std::string listed_names(const std::vector<std::string>& names) {
  constexpr size_t kMost = 12;
  const size_t shown = std::min(names.size(), kMost);
  std::string list =
      fmt::format("{}", fmt::join(names.begin(), names.begin() + ptrdiff_t(shown), ", "));
  if (shown < names.size()) list += fmt::format(" and {} more", names.size() - shown);
  return list;
}

std::vector<Split> held_out_splits_of(const std::vector<std::string>& cameras,
                                      const std::vector<std::string>& held_out,
                                      const std::string& layout) {
  std::vector<Split> splits(cameras.size(), Split::kTrain);
  for (const std::string& name : held_out) {
    const auto found = std::find(cameras.begin(), cameras.end(), name);
    if (found == cameras.end())
      throw InputError(fmt::format("{}: no camera '{}' to hold out; the cameras are {}", layout,
                                   name, listed_names(cameras)));
    splits[size_t(found - cameras.begin())] = Split::kTest;
  }
  if (std::find(splits.begin(), splits.end(), Split::kTrain) == splits.end())
    throw InputError(fmt::format(
        "{}: all cameras are held out, none is left to train on; hold out fewer", layout));
  return splits;
}

std::vector<Split> every_nth_split(const std::vector<std::string>& names, int64_t every) {
  if (every < 0 || every == 1)
    throw InputError(
        fmt::format("--test-every is {}, expected 2 or more, or 0 to hold none out", every));
  std::vector<size_t> order(names.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return names[a] < names[b]; });
  std::vector<Split> splits(names.size(), Split::kTrain);
  for (size_t i = 0; every > 0 && i < order.size(); i += size_t(every))
    splits[order[i]] = Split::kTest;
  return splits;
}

}  // namespace tessera
