// What: the page's configuration, base64.
// Not: what the page does with it (tools/player/src).
#include "tools/player_files.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"
#include "tools/player/player_page.h"

namespace tessera {
namespace {

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k)
      text.push_back(i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63] : '=');
  }
  return text;
}

}  // namespace

std::string page_of_folder() {
  return std::string(player_page());
}

std::string page_with(std::string_view tessera4d) {
  std::string page(player_page());
  const size_t at = page.find(kPlayerConfig);
  check(at != std::string::npos, "player page: its configuration is not where it should be");
  const std::string config =
      fmt::format(R"(<script id="tessera-config" type="application/json">{{"data":"{}",)"
                  R"("encoding":"base64"}}</script>)",
                  base64(tessera4d));
  return page.replace(at, kPlayerConfig.size(), config);
}

void check_page_plays(const SplatFormat& format) {
  if (std::string_view(format.name) != "glb") return;
  throw InputError(
      "export: the player cannot read .glb frames; leave --page out or choose ply, "
      "compressed, spz or splat");
}

}  // namespace tessera
