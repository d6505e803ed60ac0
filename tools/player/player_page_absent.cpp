// What: no page, in a build without npm.
// Not: the page (player_page.h).
#include "kernels/base/errors.h"
#include "tools/player/player_page.h"

namespace tessera {

std::string_view player_page() {
  throw InputError(
      "this build has no player page: install nodejs and npm, and build again with "
      "-DTESSERA_PLAYER=ON");
}

}  // namespace tessera
