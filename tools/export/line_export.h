// Writes the 4D splat files of other programs.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "static3d/line_motion/line_formats.h"
#include "tools/clip/clip.h"
#include "tools/export/formats.h"

namespace tessera {

/// FOLDER/scene.ftgs.ply
std::filesystem::path line_file_of(const std::filesystem::path& folder, const LineFormat& format);

/// One file of the whole clip; result and errors as of TimeFormat::write.
nlohmann::json export_lines(const ExportRequest& request, Clip& clip);

}  // namespace tessera
