// The web player that is built into the program: one HTML file without a scene.
#pragma once
#include <string_view>

namespace tessera {

/// The element of the page that names its scene, which the page contains once:
/// `{"scene":"manifest.json"}`, or `{"data":"<a .t4d in base64>","encoding":"base64"}` in its
/// place; each may have "truth", the images to compare with (tools/export/page_head.h).
constexpr std::string_view kPlayerConfig =
    R"(<script id="tessera-config" type="application/json">{"scene":"manifest.json"}</script>)";

/// The elements of its title and of the image that is shown while it loads, once each.
constexpr std::string_view kPlayerTitle = "<title>Tessera</title>";
constexpr std::string_view kPlayerPoster = R"(<img id="poster" alt="" hidden />)";

/// Whether the program was built with it.
bool carries_player_page();
/// UTF-8. Errors: InputError where the program was built without it.
std::string_view player_page();

}  // namespace tessera
