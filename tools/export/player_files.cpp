// What: the page's configuration, base64.
// Not: what the page does with it (tools/player/src).
#include "tools/export/player_files.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"
#include "tools/player/page_words.h"
#include "tools/player/player_page.h"

namespace tessera {

std::string page_of_folder(const PageHead& head) {
  return with_head(std::string(player_page()), head, true);
}

std::string page_with(std::string_view tessera4d, const PageHead& head) {
  std::string page = with_head(std::string(player_page()), head, false);
  const size_t position = page.find(kPlayerConfig);
  check(position != std::string::npos, "player page: its configuration is not where it should be");
  const std::string config =
      fmt::format(R"(<script id="tessera-config" type="application/json">{{"data":"{}",)"
                  R"("encoding":"base64"}}</script>)",
                  base64(tessera4d));
  return page.replace(position, kPlayerConfig.size(), config);
}

void check_page_plays(const SplatFormat& format) {
  if (std::string_view(format.name) != "glb") return;
  throw InputError(
      "export: the player cannot read .glb frames; leave --page out or choose ply, "
      "compressed, spz or splat");
}

std::string page_bytes_note(int64_t max_bytes) {
  if (max_bytes == 0 || !carries_player_page()) return "";
  return fmt::format(
      "--max-bytes counts the 4D file; a page that is exported of it adds {:.1f} MB of player",
      double(player_page().size()) / 1e6);
}

}  // namespace tessera
