// Counts the texts.
#include "ingest/checks/odd_cameras.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {

std::string odd_cameras(const std::vector<std::string>& cameras,
                        const std::vector<std::string>& texts, const char* verb) {
  check(cameras.size() == texts.size(), "odd_cameras: a text for each camera");
  std::string usual;
  std::ptrdiff_t most = 0;
  for (const std::string& text : texts)
    if (const auto count = std::count(texts.begin(), texts.end(), text); count > most) {
      most = count;
      usual = text;
    }
  std::vector<std::string> odd;
  for (size_t i = 0; i < cameras.size(); ++i)
    if (texts[i] != usual) odd.push_back(fmt::format("{} {} {}", cameras[i], verb, texts[i]));
  if (odd.empty()) return "";
  return fmt::format("{}, the other{} {}", listed_names(odd), most == 1 ? "" : "s", usual);
}

}  // namespace tessera
