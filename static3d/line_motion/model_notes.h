// What files of lines do not name, and Tessera needs to draw them as they were: rules of drawing,
// the clock, the background and a far origin, as numbers by name. Other programs pass over them.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

using ModelNotes = std::map<std::string, double>;

ModelNotes notes_of(const GaussianModel& model);
/// Those that are there; names that are not known are passed over. Errors: InputError that begins
/// with `where`: rules by which nothing can be drawn, a clip without seconds.
void take_notes(const ModelNotes& notes, const std::string& where, GaussianModel& model);

/// "tessera.filter_2d 1" of a PLY header, and the way back.
std::vector<std::string> comments_of(const ModelNotes& notes);
ModelNotes notes_in(const std::vector<std::string>& comments);
/// The member "tessera" of "asset" in meta.json.
ModelNotes notes_in(const nlohmann::json& asset);

}  // namespace tessera
