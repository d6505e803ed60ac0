// The words of a command line before they are parsed.
#pragma once
#include <string>
#include <vector>

namespace tessera {

/// `words` in reverse order, as CLI11 wants them, with "--carve true" joined into "--carve=true"
/// for the switches of the option table, so that commands of earlier versions still work.
/// Underscores in the names of options become dashes.
std::vector<std::string> joined_switches(const std::vector<std::string>& words);

}  // namespace tessera
