// What a format costs: images of a file that was read back beside those of the model that it was
// written from.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/clip/clip.h"
#include "tools/export/formats.h"

namespace tessera {

/// Of what `export` has written for `clip`, in views of at most 640 pixels: at most 20, of the
/// rig's cameras, else of an orbit, with timesteps of the frames, else spread over the clip.
/// `views`, how many; `psnr`, dB between the clip and the files drawn by its rules; and
/// `psnr_players`, the same drawn as players of 3DGS files draw, which know no other rules. Of the
/// mean squared difference of 8-bit images. Empty for the Tessera 4D file and
/// for what is not read. Errors: as
/// load_line_file, load_splat_file.
nlohmann::json export_loss(const ExportRequest& request, const Clip& clip);

/// ", 52.1 dB against the model, 41.3 dB where a player draws without antialiasing"; "" without a
/// loss.
std::string loss_text(const nlohmann::json& result);

}  // namespace tessera
