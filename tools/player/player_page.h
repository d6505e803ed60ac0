// What: the web player as one HTML file, built by npm and carried inside the program.
// Not: what it plays (tools/player_files.h).
#pragma once
#include <string_view>

namespace tessera {

/// Errors: InputError: a build without npm.
std::string_view player_page();

}  // namespace tessera
