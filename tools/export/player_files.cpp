// Writes the page's configuration, with the data as base64.
#include "tools/export/player_files.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"
#include "tools/web/page_words.h"
#include "tools/web/web_page.h"

namespace tessera {

namespace {

/// `plays`: members of the configuration that name the scene, or hold it.
std::string page_that(const std::string& plays, const PageHead& head, bool beside) {
  std::string page = with_head(std::string(player_page()), head, beside);
  const size_t position = page.find(kPlayerConfig);
  check(position != std::string::npos, "player page: its configuration is not where it should be");
  std::string truth = head.truth.empty() ? "" : ",\"truth\":" + head.truth;
  for (size_t i = 0; (i = truth.find('<', i)) != std::string::npos; i += 6)
    truth.replace(i, 1, "\\u003c");  // no text in it ends the element
  return page.replace(
      position, kPlayerConfig.size(),
      fmt::format(R"(<script id="tessera-config" type="application/json">{{{}{}}}</script>)", plays,
                  truth));
}

}  // namespace

std::string page_of_folder(const PageHead& head) {
  return page_that(R"("scene":"manifest.json")", head, true);
}

std::string page_with(std::string_view tessera4d, const PageHead& head) {
  return page_that(fmt::format(R"("data":"{}","encoding":"base64")", base64(tessera4d)), head,
                   false);
}

void check_page_plays(const SplatFormat& format) {
  const std::string_view name = format.name;
  if (name != "glb" && name != "sog") return;
  throw InputError(
      fmt::format("export: the player cannot read {} frames; leave --page out or choose ply, "
                  "compressed, spz or "
                  "splat",
                  format.extension));
}

std::string page_bytes_note(int64_t max_bytes) {
  if (max_bytes == 0 || !carries_pages()) return "";
  return fmt::format(
      "--max-bytes counts the 4D file; a page that is exported of it adds {:.1f} MB of player",
      double(player_page().size()) / 1e6);
}

}  // namespace tessera
