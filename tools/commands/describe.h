// Describes a file or folder as JSON: the facts of `tessera info`, and the sizes of models.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "tools/session/model_input.h"

namespace tessera {

/// `kind` and `path`, then what belongs to that kind; of models their accounts (model_size),
/// `with_shipped` that of the Tessera 4D file which export would write, too. Errors: InputError:
/// missing, damaged, nothing that is known, or no model where `with_shipped` requires one.
nlohmann::json describe(const std::filesystem::path& path, bool with_shipped);

/// Of a folder with transforms files, or with videos.
nlohmann::json describe_transforms(const std::filesystem::path& folder);
nlohmann::json describe_videos(const std::filesystem::path& folder);
/// Of a folder with numbered images of several cameras: how ingest reads them. Nothing where it is
/// read as something else.
std::optional<nlohmann::json> describe_sequences(const std::filesystem::path& folder);

/// `account`: {memory, and shipped of a Tessera 4D file or, where `with_shipped`, of the one that
/// export would write, which is encoded for it}, sh_degrees, temporal_extents. `path`: as on the
/// command line.
nlohmann::json model_size(const std::string& path, const ModelInput& input, bool with_shipped);

}  // namespace tessera
