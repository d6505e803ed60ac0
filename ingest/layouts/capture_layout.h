// Determines the layout of a capture folder, and lists its videos and image sequences.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/ingest.h"
#include "ingest/layouts/image_sequences.h"
#include "ingest/layouts/layout_readers.h"
#include "ingest/layouts/video_files.h"

namespace tessera {

/// What `capture` is read as: what `options` state, else by its files and by where the poses are to
/// come from. Errors: as detect_layout, and where the stated poses do not fit what is there.
CaptureLayout layout_of(const std::filesystem::path& capture, const IngestOptions& options);

/// What holds for every capture of a layout.
struct LayoutRow {
  CaptureLayout layout;
  const char* name;      // as reports and prepared scenes state it
  bool clips;            // recordings of cameras, which have clocks, rates and a length
  bool photos;           // of one scene that stands still
  bool estimates_poses;  // where none are there
  bool stated_world;     // which protocols and other programs rely on
  LayoutReader* read;
};

/// One a layout.
const std::vector<LayoutRow>& layout_rows();
const LayoutRow& row_of(CaptureLayout layout);
inline const char* layout_name(CaptureLayout layout) {
  return row_of(layout).name;
}
/// Whether there are videos that are not each the film of a photo of its name, as phones keep it.
bool has_clips(const std::filesystem::path& capture);
/// True where one of photo_folders() holds images.
bool has_images(const std::filesystem::path& capture);

/// The sequences of a capture that is read as kSequences: one a camera, or with kMoving one in all.
/// Errors: InputError: no images, or no two sequences with common numbers.
ImageSequences sequences_of(const std::filesystem::path& capture,
                            std::optional<ImageLayout> image_layout);

/// Subfolders and links that may be some, by name; hidden ones and the output folder are none of
/// them. Errors: InputError when `folder` cannot be read.
std::vector<std::filesystem::path> subfolders(const std::filesystem::path& folder,
                                              const std::filesystem::path& out);

/// Names of the subfolders that are captures; hidden ones are not looked at. Errors: none: what
/// cannot be read is no capture.
std::vector<std::string> captures_in(const std::filesystem::path& folder,
                                     std::optional<ImageLayout> image_layout = std::nullopt);

/// True when `folder` is no capture itself and some of its subfolders are. Images that may be a
/// rig's or those of several captures are a capture, whose reader says what is to be decided.
bool is_folder_of_captures(const std::filesystem::path& folder,
                           std::optional<ImageLayout> image_layout = std::nullopt);

}  // namespace tessera
