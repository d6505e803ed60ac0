// Replaces the player's page in a build without npm: an error that names the remedy.
#include "kernels/base/errors.h"
#include "tools/player/player_page.h"

namespace tessera {

bool carries_player_page() {
  return false;
}

std::string_view player_page() {
  throw InputError("this build has no player page: install nodejs and npm, and build again");
}

}  // namespace tessera
