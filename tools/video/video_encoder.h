// Encodes 8-bit RGB images with FFmpeg: to one H.264 mp4 file, with colour tags by which a correct
// decoder returns the same colours, or to a JPEG file in memory. A build without FFmpeg has
// video_encoder_absent.cpp, which encodes nothing.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "ingest/scene.h"
#include "tools/video/frame_rate.h"

namespace tessera {

/// kBySize: BT.709 from 720 lines up and BT.601 below, as players assume of files without tags.
enum class VideoColour { kBySize, kBt709 };

struct VideoFormat {
  int width = 0, height = 0;  // even
  FrameRate fps;
  int quality = 8;  // x264 crf
  VideoColour colour = VideoColour::kBySize;
};

/// yuv420p, limited range; chroma sited in the centre and tagged so; index in front. The same
/// images give the same bytes. Errors: InputError naming the file and FFmpeg's reason.
class VideoEncoder {
 public:
  VideoEncoder(const std::filesystem::path& path, const VideoFormat& format);
  ~VideoEncoder();
  VideoEncoder(const VideoEncoder&) = delete;
  VideoEncoder& operator=(const VideoEncoder&) = delete;

  /// The next frame: RGB, 3 channels, of the format's size.
  void add(const Image8& image);
  /// Completes the file and gives it its name; without it there is none, or the one before.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether this build can encode video.
bool video_encoder_available();

/// The bytes of a JFIF file without chroma subsampling; nothing in a build without FFmpeg, or with
/// one that has no JPEG encoder. `quantiser`: from 2 (best) to 31. The same image gives the same
/// bytes. `image` is RGB and not empty.
std::optional<std::string> jpeg_bytes(const Image8& image, int quantiser);

}  // namespace tessera
