// The videos of a capture, camera by camera: a file each, the chapters of a recording that the
// camera has cut into files, or a folder a camera.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/layouts/image_sequences.h"

namespace tessera {

/// The videos directly in `folder`, sorted by name.
std::vector<std::filesystem::path> videos_in(const std::filesystem::path& folder);

struct VideoCamera {
  std::string name;                          // of its folder, or of its first file
  std::vector<std::filesystem::path> files;  // chapters of one recording, in their order
};

/// The cameras whose videos lie directly in `folder`, by name: one a file, but for chapters as
/// GoPro names them (GX010012, GX020012; GOPR0012, GP010012), which are one camera. Errors:
/// InputError: a chapter between others is missing.
std::vector<VideoCamera> video_cameras_in(const std::filesystem::path& folder);

struct VideoFolders {
  std::vector<VideoCamera> cameras;  // by name
  RigEvidence evidence = RigEvidence::kNone;
  std::string seen;  // "3 folders of a video each (a, b, c)"
};

/// The sub-folders of a capture as cameras: each holds one video, or consecutive chapters: those of
/// GoPro, DJI_0001 and DJI_0002, name_1 and name_2. A rig where all are called as cameras are;
/// unclear where others have chapters or videos of one name; none where a folder holds other
/// videos, which is a capture then. Errors: as video_cameras_in.
VideoFolders find_video_folders(const std::filesystem::path& capture);

/// The cameras of a capture of videos: those in it, else its folders.
std::vector<VideoCamera> video_cameras(const std::filesystem::path& capture);

}  // namespace tessera
