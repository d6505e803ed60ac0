// HLG, PQ and BT.2020 videos become sRGB by the closed forms of their standards, and SDR videos
// keep their bytes.
#include <cmath>
#include <vector>

extern "C" {
#include <libavutil/frame.h>
}

#include "ingest/video/display_light.h"
#include "ingest/video/video_colour.h"
#include "ingest/video/video_decoder.h"
#include "ingest/video/video_timeline.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera {
namespace {

using namespace tessera::testing;

constexpr double kPqOfWhite = 0.580689;  // BT.2408, table 1: 58 % for 203 nits

using Colour = std::vector<int>;  // 8-bit RGB

/// The conversion of one pixel whose signals are 0 to 1.
Colour shown(TransferCurve transfer, ColourPrimaries primaries, double r, double g, double b) {
  FrameColour colour;
  colour.transfer = transfer;
  colour.primaries = primaries;
  const auto level = [](double v) { return uint16_t(std::lround(kFullSignal * v)); };
  const uint16_t signal[3] = {level(r), level(g), level(b)};
  uint8_t srgb[3] = {};
  srgb_of(colour, signal, 1, srgb);
  return {srgb[0], srgb[1], srgb[2]};
}

// BT.2100, table 5: the light of the scene is E'^2 / 3 up to one half, and 1 at 1.
// Bug put back: the constant c3 of PQ taken for c2; seen to fail.
TEST(DisplayLight, TheCurvesHaveTheValuesOfTheStandards) {
  EXPECT_DOUBLE_EQ(hlg_scene_light(0), 0);
  EXPECT_DOUBLE_EQ(hlg_scene_light(0.5), 1.0 / 12);
  EXPECT_NEAR(hlg_scene_light(1), 1, 1e-6);
  EXPECT_NEAR(1000 * std::pow(hlg_scene_light(0.75), 1.2), 203, 0.5);
  EXPECT_DOUBLE_EQ(pq_nits(0), 0);
  EXPECT_NEAR(pq_nits(1), 10000, 1e-6);
  EXPECT_NEAR(pq_nits(kPqOfWhite), 203, 0.01);
  EXPECT_NEAR(pq_nits(0.508078), 100, 0.01);  // BT.2408: 51 %
}

// 203 nits are white in both, what is brighter is white too, and 18 % of their light is the sRGB
// code 118. Bugs put back, each seen to fail: the system gamma of HLG left out; white at 100 nits.
TEST(DisplayLight, TwoHundredAndThreeNitsAreWhite) {
  const auto hlg = [](double v) {
    return shown(TransferCurve::kHlg, ColourPrimaries::kBt2020, v, v, v);
  };
  const auto pq = [](double v) {
    return shown(TransferCurve::kPq, ColourPrimaries::kBt2020, v, v, v);
  };
  for (const double brighter : {0.0, 0.1, 0.25}) {
    EXPECT_EQ(hlg(0.75 + brighter), Colour(3, 255));
    EXPECT_EQ(pq(kPqOfWhite + brighter), Colour(3, 255));
  }
  EXPECT_EQ(hlg(0), Colour(3, 0));
  EXPECT_EQ(pq(0), Colour(3, 0));
  // 36.54 nits: E = 0.03654^(1/1.2) = 0.063432 and E' = √(3 E); PQ by its inverse EOTF.
  EXPECT_EQ(hlg(0.436229), Colour(3, 118));
  EXPECT_EQ(pq(0.410897), Colour(3, 118));
}

// Bugs put back, each seen to fail: rows of the matrix taken for its columns; the dark codes looked
// up by light, not by its root.
TEST(DisplayLight, GreyStaysGreyAndPrimariesAreConverted) {
  for (int level = 0; level < 256; ++level) {
    const double v = level / 255.0;
    for (const TransferCurve curve : {TransferCurve::kHlg, TransferCurve::kPq}) {
      const Colour grey = shown(curve, ColourPrimaries::kBt2020, v, v, v);
      EXPECT_EQ(grey, Colour(3, grey[0])) << level;
    }
    EXPECT_EQ(shown(TransferCurve::kSdr, ColourPrimaries::kBt2020, v, v, v), Colour(3, level));
  }
  // BT.2087: red, green and blue of BT.709 in linear BT.2020, as signals of BT.1886.
  const auto sdr = [](double r, double g, double b) {
    const auto v = [](double light) { return std::pow(light, 1 / 2.4); };
    return shown(TransferCurve::kSdr, ColourPrimaries::kBt2020, v(r), v(g), v(b));
  };
  const auto expect_near = [](const Colour& seen, const Colour& expected) {
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], expected[c], 6) << c;
  };
  expect_near(sdr(0.627404, 0.069097, 0.016391), {255, 0, 0});
  expect_near(sdr(0.329283, 0.919540, 0.088013), {0, 255, 0});
  expect_near(sdr(0.043313, 0.011362, 0.895595), {0, 0, 255});
}

/// A grey frame of 10 bits, limited range, with this luma.
LibavOwned<AVFrame> grey_frame(int luma, AVColorTransferCharacteristic transfer) {
  LibavOwned<AVFrame> frame = new_frame();
  frame->width = 32;
  frame->height = 16;
  frame->format = AV_PIX_FMT_YUV420P10;
  frame->colorspace = AVCOL_SPC_BT2020_NCL;
  frame->color_range = AVCOL_RANGE_MPEG;
  frame->color_trc = transfer;
  EXPECT_EQ(av_frame_get_buffer(frame.get(), 0), 0);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < (c == 0 ? 16 : 8); ++y)
      for (int x = 0; x < (c == 0 ? 32 : 16); ++x)
        reinterpret_cast<uint16_t*>(frame->data[c] + y * frame->linesize[c])[x] =
            uint16_t(c == 0 ? luma : 512);
  return frame;
}

// The codes of 10 bits for white are 64 + 876 E'. Bugs put back, each seen to fail: the range of
// the frame not handed to swscale; 65,535 taken for its full signal.
TEST(FrameColour, TenBitCodesForWhiteAreWhite) {
  FrameToRgb to_rgb;
  const auto level = [&](int luma, AVColorTransferCharacteristic transfer) {
    const auto frame = grey_frame(luma, transfer);
    const Image8 image = to_rgb.convert(*frame, {});
    EXPECT_EQ(image.data, std::vector<uint8_t>(32 * 16 * 3, image.data.front()));
    return int(image.data.front());
  };
  EXPECT_EQ(level(721, AVCOL_TRC_ARIB_STD_B67), 255);
  EXPECT_EQ(level(940, AVCOL_TRC_ARIB_STD_B67), 255);
  EXPECT_EQ(level(64, AVCOL_TRC_ARIB_STD_B67), 0);
  EXPECT_EQ(level(573, AVCOL_TRC_SMPTE2084), 255);
  EXPECT_EQ(level(64, AVCOL_TRC_SMPTE2084), 0);
  EXPECT_NEAR(level(64 + 382, AVCOL_TRC_ARIB_STD_B67), 118, 1);
  EXPECT_NEAR(level(64 + 360, AVCOL_TRC_SMPTE2084), 118, 1);
}

class StatedColour : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_encode_video()) GTEST_SKIP() << "this FFmpeg has no H.264 encoder";
    video_.frames = {coded_image(80, 64, 5)};
    video_.chroma = VideoChroma::k444;
  }
  VideoFrame decoded() {
    write_video(folder_ / "a.mp4", video_);
    VideoFrame first;
    decode_video(folder_ / "a.mp4", [&](VideoFrame frame) {
      first = std::move(frame);
      return false;
    });
    return first;
  }
  TemporaryFolder folder_;
  TestVideo video_;
};

// Bug put back: BT.709 curves sent through the display's light; seen to fail.
TEST_F(StatedColour, SdrKeepsItsBytes) {
  const VideoFrame unstated = decoded();
  video_.transfer = VideoTransfer::kBt709;
  for (const VideoPrimaries primaries :
       {VideoPrimaries::kUnstated, VideoPrimaries::kBt601, VideoPrimaries::kBt709}) {
    video_.primaries = primaries;
    const VideoFrame stated = decoded();
    EXPECT_EQ(stated.image.data, unstated.image.data);
    EXPECT_STREQ(tone_map_of(stated.colour), "none");
  }
}

// A turned video of each kind equals the conversion of what the same file shows as SDR, within what
// 8 bits of it leave. Bug put back: the image not turned on the way of 16 bits; seen to fail.
TEST_F(StatedColour, HdrIsConvertedAndRecorded) {
  video_.display_matrix = {{0, 1, -1, 0}};
  const Image8 signals = decoded().image;
  struct Case {
    VideoTransfer stated;
    TransferCurve curve;
    const char* tone_map;
  };
  for (const Case& c :
       {Case{VideoTransfer::kHlg, TransferCurve::kHlg, "hlg to srgb, 203 nits white"},
        Case{VideoTransfer::kPq, TransferCurve::kPq, "pq to srgb, 203 nits white"},
        Case{VideoTransfer::kUnstated, TransferCurve::kSdr, "bt2020 primaries to bt709"}}) {
    video_.transfer = c.stated;
    video_.primaries = VideoPrimaries::kBt2020;
    const VideoFrame seen = decoded();
    EXPECT_STREQ(tone_map_of(seen.colour), c.tone_map);
    ASSERT_EQ(seen.image.width, 64);
    ASSERT_EQ(seen.image.data.size(), signals.data.size());
    size_t differing = 0;
    for (size_t p = 0; p < signals.data.size(); p += 3) {
      const Colour expected = shown(c.curve, ColourPrimaries::kBt2020, signals.data[p] / 255.0,
                                    signals.data[p + 1] / 255.0, signals.data[p + 2] / 255.0);
      for (size_t k = 0; k < 3; ++k)
        if (std::abs(seen.image.data[p + k] - expected[k]) > 12) ++differing;
    }
    EXPECT_LT(differing, signals.data.size() / 50) << c.tone_map;
  }
}

// Before and while frames are decoded. Bugs put back, each seen to fail: logarithmic curves taken
// for SDR; the timeline read without a look at its colours.
TEST_F(StatedColour, WhatHasNoConversionIsRefusedWithItsCommand) {
  const auto expect_refused = [&](const std::string& stated) {
    const std::vector<std::string> named{"a.mp4", stated, "ffmpeg -i IN -vf zscale=matrix=bt709"};
    expect_input_error([&] { decoded(); }, named);
    expect_input_error([&] { read_timeline(folder_ / "a.mp4"); }, named);
  };
  video_.transfer = VideoTransfer::kLog;
  expect_refused("transfer curve log100");
  video_.transfer = VideoTransfer::kUnstated;
  video_.stated = VideoMatrix::kBt2020Constant;
  expect_refused("matrix bt2020c");
}

// However many frames are so. Bugs put back, each seen to fail: a progressive order
// of fields taken for interlaced; the flag of the frame not read.
TEST_F(StatedColour, InterlacedFramesAreNoted) {
  for (int i = 0; i < 6; ++i) video_.frames.push_back(coded_image(80, 64, i));
  EXPECT_FALSE(decoded().colour.interlaced);
  EXPECT_TRUE(read_timeline(folder_ / "a.mp4").warnings.empty());
  video_.interlaced = true;
  EXPECT_TRUE(decoded().colour.interlaced);
  EXPECT_TRUE(read_timeline(folder_ / "a.mp4").colour.interlaced);
}

}  // namespace
}  // namespace tessera
