// Floaters leave a model that is exported.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "tools/export/formats.h"

namespace tessera {

/// A floater is known by what the training cameras show of it; of fewer places than this, no one
/// can say what only one of them can see.
inline constexpr int kLeastPlaces = 3;

/// Removes them (recon4d/reduction/floaters.h) and returns how many there were. `scene`: folder or
/// transforms file with the cameras of the training, in whose world the model is or was. Nothing
/// where its training cameras stand in fewer than kLeastPlaces places.
/// Errors: InputError: unreadable.
std::optional<int64_t> clean_model(const std::filesystem::path& scene, GaussianModel& model);

/// The same where `request` asks for it, or says nothing and writes a page whose scene is there and
/// can be read. How many were removed; null where it was not done.
/// Errors: InputError: asked for, but the clip has several windows, or the scene is not there or
/// has too few cameras.
nlohmann::json clean_if_asked(const ExportRequest& request, Clip& clip);

}  // namespace tessera
