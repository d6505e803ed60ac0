// Replaces the web pages in a build without Node.js: an error that names the remedy.
#include "kernels/base/errors.h"
#include "tools/web/web_page.h"

namespace tessera {

bool carries_pages() {
  return false;
}

std::string_view player_page() {
  throw InputError("this build has no web pages: install nodejs and curl, and build again");
}

std::string_view report_page() {
  return player_page();
}

}  // namespace tessera
