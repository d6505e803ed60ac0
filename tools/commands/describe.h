// Describes a file or folder as JSON: the facts of `tessera info`, and the sizes of models.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace tessera {

/// `kind` and `path`, then what belongs to that kind; of models `with_shipped` also
/// `shipped_bytes`, the size of the Tessera 4D file which export would write. Errors: InputError:
/// missing, damaged, nothing that is known, or no model where `with_shipped` requires one.
nlohmann::json describe(const std::filesystem::path& path, bool with_shipped);

/// Of a folder with transforms files, or with videos.
nlohmann::json describe_transforms(const std::filesystem::path& folder);
nlohmann::json describe_videos(const std::filesystem::path& folder);
/// Of a folder of photos, with or without poses. Nothing where it is read as something else.
/// Errors: InputError: its poses cannot be read.
std::optional<nlohmann::json> describe_photos(const std::filesystem::path& folder);
/// Of a folder with numbered images of several cameras: how ingest reads them. Nothing where it is
/// read as something else.
std::optional<nlohmann::json> describe_sequences(const std::filesystem::path& folder);

}  // namespace tessera
