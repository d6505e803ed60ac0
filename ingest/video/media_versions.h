// Versions of the media libraries that this build uses.
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace tessera {

/// {"FFmpeg", "5.1.6"}, …; empty in a trainer-only build.
std::vector<std::pair<std::string, std::string>> media_versions();

}  // namespace tessera
