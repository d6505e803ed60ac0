// Figures of other programs, on their hardware, from a file that a user has written.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>

namespace tessera {

/// An array of {name, scene, psnr (dB), seconds, device, and bytes where known}, or an object that
/// has it as `entries`. Errors: InputError naming the file and what an entry lacks.
nlohmann::json read_published(const std::filesystem::path& file);

}  // namespace tessera
