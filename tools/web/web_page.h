// The web pages that are built into the program, one HTML file each: the player without a scene,
// and the report without data.
#pragma once
#include <string_view>

namespace tessera {

/// The element of the player that names its scene, which the page contains once:
/// `{"scene":"manifest.json"}`, or `{"data":"<a .t4d in base64>","encoding":"base64"}` in its
/// place; each may have "truth", the images to compare with (tools/export/page_head.h).
constexpr std::string_view kPlayerConfig =
    R"(<script id="tessera-config" type="application/json">{"scene":"manifest.json"}</script>)";

/// The elements of the title, of either page, and of the image that the player shows while it
/// loads, once each.
constexpr std::string_view kPageTitle = "<title>Tessera</title>";
constexpr std::string_view kPlayerPoster = R"(<img id="poster" alt="" hidden />)";

/// The element of the report that has its data, once.
constexpr std::string_view kReportData =
    R"(<script id="tessera-report" type="application/json">null</script>)";

/// Whether the program was built with the pages.
bool carries_pages();
/// UTF-8. Errors: InputError where the program was built without them.
std::string_view player_page();
std::string_view report_page();

}  // namespace tessera
