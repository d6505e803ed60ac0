// The page from its three files, which CMake reads.
#include "tools/view/live_page.h"

#include <string_view>

namespace tessera {
namespace {

#include "tools/view/live_page.inc"

void fill(std::string& page, std::string_view place, std::string_view text) {
  page.replace(page.find(place), place.size(), text);
}

}  // namespace

std::string live_page() {
  std::string page = kHtml;
  fill(page, "/* live.css */", kCss);
  fill(page, "/* live.js */", kScript);
  return page;
}

}  // namespace tessera
