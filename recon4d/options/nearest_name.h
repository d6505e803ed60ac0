// Suggestions of known names for a mistyped one, and the words that present them in error messages.
#pragma once
#include <string>
#include <vector>

namespace tessera {

/// Levenshtein's distance, in which two neighbours that changed places count once.
size_t edit_distance(const std::string& a, const std::string& b);

/// The nearest name at a distance of at most a third of the typed letters (dashes in front are none
/// of them); "" where none is as near.
std::string nearest_name(const std::string& typed, const std::vector<std::string>& known);

/// "; did you mean 'fast'?", of names that begin with what was typed, else of the nearest one;
/// "" where there is none.
std::string did_you_mean(const std::string& typed, const std::vector<std::string>& known);

/// The same, and then all names: "; did you mean 'fast'? There are fast, best" or "; there are …".
std::string known_names(const std::string& typed, const std::vector<std::string>& known);

}  // namespace tessera
