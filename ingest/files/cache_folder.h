// The folder of the user in which programs keep what they could make again.
#pragma once
#include <filesystem>

namespace tessera {

/// $XDG_CACHE_HOME/tessera, else $HOME/.cache/tessera; empty where neither variable is an absolute
/// path. It need not exist.
std::filesystem::path user_cache_folder();

}  // namespace tessera
