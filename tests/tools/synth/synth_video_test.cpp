// The mp4 files, decoded with libav and the file's colour tags, against the rendered images, and
// poses_bounds.npy against the rig.
#include <gtest/gtest.h>
#include <unistd.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "ingest/files/atomic_file.h"
#include "ingest/files/npy.h"
#include "ingest/files/png.h"
#include "tools/synth/ground_truth.h"
#include "tools/synth/rigs.h"
#include "tools/synth/sensor.h"
#include "tools/video/video_encoder.h"

namespace tessera::synth {
namespace {

namespace fs = std::filesystem;

struct Decoded {
  std::vector<Image8> frames;
  std::vector<double> seconds;
  AVColorSpace matrix = AVCOL_SPC_UNSPECIFIED;
  AVColorRange range = AVCOL_RANGE_UNSPECIFIED;
};

Image8 to_rgb(const AVFrame& frame) {
  Image8 image{frame.width, frame.height, 3, {}};
  image.data.resize(size_t(3 * frame.width * frame.height));
  SwsContext* sws = sws_getContext(frame.width, frame.height, AVPixelFormat(frame.format),
                                   frame.width, frame.height, AV_PIX_FMT_RGB24,
                                   SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr,
                                   nullptr, nullptr);
  const int* table = sws_getCoefficients(frame.colorspace);  // AVColorSpace numbers are its own
  sws_setColorspaceDetails(sws, table, frame.color_range == AVCOL_RANGE_JPEG, table, 1, 0, 1 << 16,
                           1 << 16);
  uint8_t* to[] = {image.data.data()};
  const int stride[] = {3 * frame.width};
  sws_scale(sws, frame.data, frame.linesize, 0, frame.height, to, stride);
  sws_freeContext(sws);
  return image;
}

Decoded decode(const fs::path& path) {
  Decoded result;
  AVFormatContext* file = nullptr;
  if (avformat_open_input(&file, path.c_str(), nullptr, nullptr) < 0) return result;
  avformat_find_stream_info(file, nullptr);
  const AVStream* stream = file->streams[0];
  AVCodecContext* codec = avcodec_alloc_context3(avcodec_find_decoder(stream->codecpar->codec_id));
  avcodec_parameters_to_context(codec, stream->codecpar);
  avcodec_open2(codec, nullptr, nullptr);
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  for (bool more = true; more;) {
    more = av_read_frame(file, packet) >= 0;
    avcodec_send_packet(codec, more ? packet : nullptr);
    av_packet_unref(packet);
    while (avcodec_receive_frame(codec, frame) >= 0) {
      result.frames.push_back(to_rgb(*frame));
      result.seconds.push_back(double(frame->pts) * av_q2d(stream->time_base));
      result.matrix = frame->colorspace;
      result.range = frame->color_range;
    }
  }
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&codec);
  avformat_close_input(&file);
  return result;
}

double mean_error(const Image8& a, const Image8& b) {
  double sum = 0;
  for (size_t i = 0; i < a.data.size(); ++i) sum += std::abs(int(a.data[i]) - int(b.data[i]));
  return sum / double(a.data.size());
}

class SynthVideo : public ::testing::Test {
 protected:
  SynthVideo() {
    folder_ = fs::path(::testing::TempDir()) / ("synth_video_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    options_.cameras = 3;
    options_.frames = 11;
    options_.width = 240;
    options_.height = 180;
    options_.points = 100;
  }
  ~SynthVideo() override { fs::remove_all(folder_); }

  fs::path folder_;
  SynthOptions options_;
};

// Seen to fail: frames handed over twice; time stamps doubled.
TEST_F(SynthVideo, DecodesToWhatWasRendered) {
  options_.fps = {30000, 1001};
  make_capture(options_, folder_ / "room", {});
  const World world = build_world(options_.scene, options_.seed, 0);
  const std::vector<Camera> cameras = video_rig(options_, world.target);
  for (int number = 0; number < 3; ++number) {
    const Decoded video = decode(folder_ / "room" / ("cam0" + std::to_string(number) + ".mp4"));
    ASSERT_EQ(video.frames.size(), 11u);
    EXPECT_EQ(video.matrix, AVCOL_SPC_SMPTE170M);
    EXPECT_EQ(video.range, AVCOL_RANGE_MPEG);
    const StaticLayer layer = render_static(world, cameras[size_t(number)], 3);
    for (int frame = 0; frame < 11; ++frame) {
      const RenderedImage truth =
          render(world, cameras[size_t(number)], normalised_time(options_, frame), layer);
      EXPECT_LT(mean_error(video.frames[size_t(frame)], expose(truth, options_, 3, number, frame)),
                3);
      EXPECT_NEAR(video.seconds[size_t(frame)], frame * 1001 / 30000.0, 1e-4);
      char name[64];
      std::snprintf(name, sizeof(name), "mask_cam%02d_%04d.png", number, frame);
      EXPECT_EQ(read_png(folder_ / "room/ground_truth" / name).data, truth.mask);
    }
  }
}

// A camera shifted by s shows at frame k what one without shift would at instant k + s; its stamps
// stay, and instants beyond the clip's ends are rendered too. The other cameras are the same bytes
// as without it.
TEST_F(SynthVideo, ShiftedCameraFilmsLater) {
  options_.shifts = {0, 2.5, -1.3};
  make_capture(options_, folder_ / "shifted", {});
  const World world = build_world(options_.scene, options_.seed, 0);
  const std::vector<Camera> cameras = video_rig(options_, world.target);
  for (const int number : {1, 2}) {
    const Decoded video = decode(folder_ / "shifted" / ("cam0" + std::to_string(number) + ".mp4"));
    const StaticLayer layer = render_static(world, cameras[size_t(number)], 3);
    for (const int frame : {0, 5, 10}) {
      const double instant = frame + options_.shifts[size_t(number)];
      const RenderedImage truth =
          render(world, cameras[size_t(number)], instant / (options_.frames - 1), layer);
      EXPECT_LT(mean_error(video.frames[size_t(frame)], expose(truth, options_, 3, number, frame)),
                3);
      char name[64];
      std::snprintf(name, sizeof(name), "mask_cam%02d_%04d.png", number, frame);
      EXPECT_EQ(read_png(folder_ / "shifted/ground_truth" / name).data, truth.mask);
      EXPECT_NEAR(video.seconds[size_t(frame)], frame / 24.0, 1e-4);
    }
  }
  const std::string truth = read_text_file(folder_ / "shifted/ground_truth.json");
  EXPECT_NE(truth.find("\"shift_frames\": 2.5"), std::string::npos);
  EXPECT_NE(truth.find("\"shift_frames\": -1.3"), std::string::npos);
  options_.shifts = {};
  make_capture(options_, folder_ / "plain", {});
  EXPECT_EQ(read_text_file(folder_ / "shifted/cam00.mp4"),
            read_text_file(folder_ / "plain/cam00.mp4"));
  EXPECT_EQ(read_text_file(folder_ / "plain/ground_truth.json").find("shift"), std::string::npos);
}

// Flat colours have no chroma edges: what is left is the matrix and the range.
// Seen to fail: the two matrices exchanged (13 levels); full range under a limited tag (13).
TEST_F(SynthVideo, FlatColoursReturnWithinTwoLevels) {
  for (const int height : {96, 720}) {
    const int width = 128;
    const uint8_t colours[4][3] = {{200, 60, 40}, {40, 180, 70}, {60, 50, 210}, {128, 128, 128}};
    Image8 image{width, height, 3, {}};
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int k = 0; k < 3; ++k) image.data.push_back(colours[x / 32][k]);
    VideoEncoder encoder(folder_ / "flat.mp4", {width, height, {24, 1}, 4});
    for (int frame = 0; frame < 3; ++frame) encoder.add(image);
    encoder.finish();
    const Decoded video = decode(folder_ / "flat.mp4");
    ASSERT_EQ(video.frames.size(), 3u);
    EXPECT_EQ(video.matrix, height == 720 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M);
    for (int band = 0; band < 4; ++band)
      for (int k = 0; k < 3; ++k) {
        const size_t sample = size_t(3 * ((height / 2) * width + 32 * band + 16) + k);
        EXPECT_NEAR(video.frames[1].data[sample], colours[band][k], 2)
            << height << " band " << band;
      }
  }
}

// Chroma that is sited elsewhere than tagged shifts a ramp of chroma at equal brightness.
// Seen to fail: dst_v_chr_pos 0 (0.8 in y), dst_h_chr_pos 0 (0.8 in x).
TEST_F(SynthVideo, ChromaIsSitedInTheCentre) {
  for (const bool across : {true, false}) {
    const int size = 96;
    Image8 image{size, size, 3, {}};
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const int ramp = 2 * (across ? x : y);
        for (const int level : {30 + ramp, 128, 220 - ramp}) image.data.push_back(uint8_t(level));
      }
    VideoEncoder encoder(folder_ / "ramp.mp4", {size, size, {24, 1}, 1});
    encoder.add(image);
    encoder.finish();
    const Decoded video = decode(folder_ / "ramp.mp4");
    ASSERT_EQ(video.frames.size(), 1u);
    double shift = 0;
    for (int y = 20; y < 76; ++y)
      for (int x = 20; x < 76; ++x) {
        const size_t sample = size_t(3 * (y * size + x));
        shift += int(video.frames[0].data[sample]) - int(image.data[sample]);
      }
    EXPECT_NEAR(shift / (56 * 56), 0, 0.4) << (across ? "x" : "y");
  }
}

// Written out from LLFF's definition, not by the writer's code. Rows follow the sorted names.
// Seen to fail: down and right exchanged; cam00 at the end of the arc.
TEST_F(SynthVideo, PosesBoundsIsLlff) {
  options_.cameras = 12;
  options_.frames = 1;
  make_capture(options_, folder_ / "room", {});
  const Matrix rows = read_npy(folder_ / "room/poses_bounds.npy");
  ASSERT_EQ(rows.rows, 12);
  ASSERT_EQ(rows.columns, 17);
  const World world = build_world(options_.scene, options_.seed, 0);
  const std::vector<Camera> cameras = video_rig(options_, world.target);
  double left = 0, right = 0;
  for (int64_t row = 0; row < 12; ++row) {
    const Camera& camera = cameras[size_t(row)];
    const glm::dmat3 axes = glm::transpose(camera.cam_from_world);  // right, down, forward
    for (int i = 0; i < 3; ++i) {
      EXPECT_DOUBLE_EQ(rows(row, 5 * i), axes[1][i]);
      EXPECT_DOUBLE_EQ(rows(row, 5 * i + 1), axes[0][i]);
      EXPECT_DOUBLE_EQ(rows(row, 5 * i + 2), -axes[2][i]);
      EXPECT_NEAR(rows(row, 5 * i + 3), camera.position()[i], 1e-12);
    }
    EXPECT_EQ(rows(row, 4), 180);
    EXPECT_EQ(rows(row, 9), 240);
    EXPECT_DOUBLE_EQ(rows(row, 14), camera.fl_x);
    EXPECT_GT(rows(row, 15), 0.5);  // near, then far: the room is 7.7 m long
    EXPECT_LT(rows(row, 15), 3);
    EXPECT_GT(rows(row, 16), 6);
    EXPECT_LT(rows(row, 16), 9);
    left = std::min(left, camera.position().x);
    right = std::max(right, camera.position().x);
  }
  EXPECT_LT(std::abs(cameras[0].position().x), 0.1) << "cam00 stands in the middle";
  EXPECT_LT(left, -1.5);
  EXPECT_GT(right, 1.5);
}

// Seen to fail: a running counter drawn into the frames; the flag faststart left out; x264's mbtree
// left on (in 2 of 5 runs).
TEST_F(SynthVideo, SameSeedSameBytesAndRawVideosHaveNoPoses) {
  options_.layout = SynthLayout::kVideos;
  make_capture(options_, folder_ / "a", {});
  make_capture(options_, folder_ / "b", {});
  for (const char* name : {"cam00.mp4", "cam02.mp4", "ground_truth.json"})
    EXPECT_EQ(read_text_file(folder_ / "a" / name), read_text_file(folder_ / "b" / name)) << name;
  EXPECT_FALSE(fs::exists(folder_ / "a/poses_bounds.npy"));
  const std::string bytes = read_text_file(folder_ / "a/cam00.mp4");
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat")) << "the index comes first";
}

}  // namespace
}  // namespace tessera::synth
