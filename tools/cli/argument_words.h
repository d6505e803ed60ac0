// The words of a command line before they are parsed.
#pragma once
#include <string>
#include <vector>

namespace tessera {

/// `words` in reverse order, as CLI11 wants them, with "--carve true" joined into "--carve=true"
/// for the switches of the option table, so that commands of earlier versions still work.
/// Underscores in the names of options become dashes.
std::vector<std::string> joined_switches(const std::vector<std::string>& words);

/// "--carve is 'maybe', expected no value, true or false" of the first switch whose value cannot be
/// read; empty where there is none.
std::string switch_complaint(const std::vector<std::string>& words);

}  // namespace tessera
