// The frames of decode_frames equal those of decoding everything, whichever frames are skipped.
#include <fmt/format.h>

#include "ingest/video/frame_decoder.h"
#include "ingest/video/video_decoder.h"
#include "ingest/video/video_timeline.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera {
namespace {

using namespace tessera::testing;

struct SeekCase {
  const char* encoder;
  const char* extension;
  bool open_groups;
  int keyframe_distance;
};

class VideoSeek : public ::testing::TestWithParam<SeekCase> {
 protected:
  void SetUp() override {
    const SeekCase& codec = GetParam();
    if (!can_encode_video(codec.encoder))
      GTEST_SKIP() << "this FFmpeg has no encoder " << codec.encoder;
    TestVideo video;
    video.encoder = codec.encoder;
    video.open_groups = codec.open_groups;
    video.keyframe_distance = codec.keyframe_distance;
    video.b_frames = 3;
    for (int i = 0; i < kFrames; ++i) {
      video.frames.push_back(coded_image(80, 48, i));
      video.ticks.push_back(512 * (i + i / 11) + 13 * (i % 5));  // uneven
    }
    path_ = folder_ / (std::string("clip") + codec.extension);
    write_video(path_, video);
    decode_video(path_, [&](VideoFrame frame) {
      all_.push_back(std::move(frame));
      return true;
    });
    ASSERT_EQ(all_.size(), size_t(kFrames));
  }
  void expect_frames(const std::vector<size_t>& wanted) {
    std::vector<int64_t> ticks;
    for (const size_t i : wanted) ticks.push_back(all_[i].ticks);
    size_t position = 0;
    decode_frames(path_, ticks, [&](VideoFrame frame) {
      const VideoFrame& expected = all_[wanted[position]];
      EXPECT_EQ(frame.ticks, expected.ticks);
      EXPECT_EQ(coded_number(frame.image), int(wanted[position]));
      EXPECT_EQ(frame.image.data, expected.image.data) << wanted[position];
      ++position;
      return true;
    });
    EXPECT_EQ(position, wanted.size());
  }
  static constexpr int kFrames = 120;
  TemporaryFolder folder_;
  std::filesystem::path path_;
  std::vector<VideoFrame> all_;
};

// Bug put back: jumps to a keyframe after the wanted frame, and no second try without jumps; seen
// to fail.
TEST_P(VideoSeek, EveryFrameAloneEqualsSequentialDecoding) {
  for (size_t i = 0; i < size_t(kFrames); i += 3) expect_frames({i});
  expect_frames({size_t(kFrames) - 1});
}

TEST_P(VideoSeek, SparseAndDenseSelections) {
  std::vector<size_t> every_frame, tenth, uneven;
  for (size_t i = 0; i < size_t(kFrames); ++i) every_frame.push_back(i);
  for (size_t i = 4; i < size_t(kFrames); i += 10) tenth.push_back(i);
  for (const size_t i : {1, 2, 3, 47, 48, 59, 60, 61, 95, 96, 118}) uneven.push_back(i);
  expect_frames(every_frame);
  expect_frames(tenth);
  expect_frames(uneven);
}

// The frames are those that read_timeline announces without decoding. Bug put back: packets left in
// order of decoding; seen to fail.
TEST_P(VideoSeek, TimelineAnnouncesWhatDecodingGives) {
  std::vector<int64_t> decoded;
  for (const VideoFrame& frame : all_) decoded.push_back(frame.ticks);
  EXPECT_EQ(read_timeline(path_).ticks, decoded);
}

INSTANTIATE_TEST_SUITE_P(Containers, VideoSeek,
                         ::testing::Values(SeekCase{"libx264", ".mp4", false, 12},
                                           SeekCase{"libx264", ".mkv", true, 30},
                                           SeekCase{"libx264", ".ts", false, 24},
                                           SeekCase{"libx265", ".mov", true, 16},
                                           SeekCase{"libx265", ".mkv", true, 30},
                                           SeekCase{"libvpx-vp9", ".webm", false, 20},
                                           SeekCase{"libaom-av1", ".mkv", false, 24},
                                           SeekCase{"libaom-av1", ".mp4", false, 30}),
                         [](const auto& named) {
                           std::string name = std::string(named.param.encoder) +
                                              named.param.extension +
                                              std::to_string(named.param.keyframe_distance);
                           for (char& c : name)
                             if (c == '-' || c == '.') c = '_';
                           return name;
                         });

class VideoFrames : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_encode_video()) GTEST_SKIP() << "this FFmpeg has no H.264 encoder";
    for (int i = 0; i < 100; ++i) video_.frames.push_back(coded_image(80, 48, i));
  }
  TemporaryFolder folder_;
  TestVideo video_;
};

// Packets that no wanted frame needs are not decoded: a jump starts with its keyframe.
TEST_F(VideoFrames, JumpsToTheKeyframeBeforeTheWantedFrame) {
  write_video(folder_ / "a.mp4", video_);
  FrameDecoder decoder(folder_ / "a.mp4");
  decoder.jump_to(84);  // keyframes every 12 frames
  const LibavOwned<AVFrame> frame = new_frame();
  ASSERT_TRUE(decoder.next(*frame));
  EXPECT_EQ(frame->pts, 84 * kTestTicksPerFrame);
  EXPECT_EQ(decoder.frames_given(), 1);
}

// Finds: packets in between are read; the keyframe after the wanted frame is taken.
TEST_F(VideoFrames, ByTheIndexReadsNothingInBetween) {
  for (const char* name : {"a.mp4", "a.mkv"}) {
    video_.b_frames = 2;
    write_video(folder_ / name, video_);
    const std::vector<int64_t> ticks = read_timeline(folder_ / name).ticks;
    FrameDecoder decoder(folder_ / name);
    ASSERT_TRUE(decoder.find_index());
    EXPECT_EQ(decoder.seek_towards(ticks[13]), FrameDecoder::Seek::kStays) << "too near to pay";
    ASSERT_EQ(decoder.seek_towards(ticks[95]), FrameDecoder::Seek::kMoved) << name;
    const LibavOwned<AVFrame> frame = new_frame();
    while (decoder.last_ticks().value_or(-1) < ticks[95]) ASSERT_TRUE(decoder.next(*frame));
    EXPECT_EQ(frame->pts, ticks[95]);
    EXPECT_LE(decoder.packets_read(), 12 + 20) << name << ": a group and what the codec holds";
  }
}

TEST_F(VideoFrames, StopsWhenAskedToAndNamesAMissingTime) {
  write_video(folder_ / "a.mp4", video_);
  int seen = 0;
  decode_frames(folder_ / "a.mp4", {0, 512, 1024}, [&](VideoFrame) { return ++seen < 2; });
  EXPECT_EQ(seen, 2);
  expect_input_error(
      [&] {
        decode_frames(folder_ / "a.mp4", {0, 60 * 512 + 5}, [](VideoFrame) { return true; });
      },
      {"a.mp4", "camera a", "no frame at 2.400391 s"});
}

// B15, edit lists: frames before tick 0 are in the file and not shown. Bug put back: discarded
// packets kept in the timeline; seen to fail.
TEST_F(VideoFrames, EditListsCutOffFrames) {
  for (int i = 0; i < 100; ++i) video_.ticks.push_back(512 * (i - 17));
  for (const char* name : {"a.mp4", "a.mov"}) {
    write_video(folder_ / name, video_);
    const VideoTimeline timeline = read_timeline(folder_ / name);
    ASSERT_EQ(timeline.ticks.size(), 83u) << name;
    EXPECT_EQ(timeline.ticks.front(), 0);
    EXPECT_TRUE(timeline.warnings.empty());
    int number = 17;
    decode_video(folder_ / name, [&](VideoFrame frame) {
      EXPECT_EQ(frame.ticks, 512 * (number - 17)) << name;
      EXPECT_EQ(coded_number(frame.image), number++) << name;
      return true;
    });
    EXPECT_EQ(number, 100);
    decode_frames(folder_ / name, {512, 70 * 512}, [&](VideoFrame frame) {
      EXPECT_EQ(coded_number(frame.image), int(frame.ticks / 512) + 17) << name;
      return true;
    });
  }
}

}  // namespace
}  // namespace tessera
