// Compares what the cameras' videos state, by name (colour_name).
#include "ingest/checks/mixed_colours.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {

std::string mixed_colours(const std::vector<std::string>& cameras,
                          const std::vector<FrameColour>& colours) {
  check(cameras.size() == colours.size(), "mixed_colours: a colour for each camera");
  std::vector<std::string> names;
  for (const FrameColour& colour : colours) names.push_back(colour_name(colour));
  std::string usual;
  std::ptrdiff_t most = 0;
  for (const std::string& name : names)
    if (const auto count = std::count(names.begin(), names.end(), name); count > most) {
      most = count;
      usual = name;
    }
  std::vector<std::string> odd;
  for (size_t i = 0; i < cameras.size(); ++i)
    if (names[i] != usual) odd.push_back(fmt::format("{} is {}", cameras[i], names[i]));
  if (odd.empty()) return "";
  return fmt::format(
      "{}, the other{} {}: all become sRGB, but cameras render what they film in different ways; "
      "film with one setting",
      listed_names(odd), most == 1 ? "" : "s", usual);
}

}  // namespace tessera
