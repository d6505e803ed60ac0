// What: clocks of rigs whose shifts are known, found from motion, end to end.
// Not: stated offsets and sound alone (sync_sources_test.cpp), or the solver
// (offset_solver_test.cpp).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "tests/ingest/sync_fixture.h"
#include "tests/support/data_folder.h"
#include "tests/support/scratch_folder.h"
#include "tools/synth/video_encoder.h"

namespace tessera {
namespace {

using namespace tessera::testing;

ClipClocks by_motion(const std::vector<RigClip>& clips) {
  return synchronise(clips, {SyncMethod::kMotion, {}}, {});
}

/// A clip in which nothing moves, with the pose of `clip`.
RigClip still_clip(const RigClip& clip, const std::filesystem::path& path) {
  RigClip still = clip;
  still.name = "cam09", still.video = path;
  Image8 picture{clip.timeline.width, clip.timeline.height, 3, {}};
  for (int i = 0; i < picture.width * picture.height * 3; ++i)
    picture.data.push_back(uint8_t(60 + (i * 7) % 90));
  synth::VideoEncoder encoder(path, {picture.width, picture.height, {30, 1}, 8});
  for (size_t i = 0; i < clip.timeline.ticks.size(); ++i) encoder.add(picture);
  encoder.finish();
  still.timeline = read_timeline(path);
  return still;
}

/// `clip` with noise as its sound, which starts `late` seconds after the picture does.
RigClip with_sound(const RigClip& clip, const std::filesystem::path& noise, double late) {
  RigClip heard = clip;
  heard.video = noise.parent_path() / (clip.name + "_sound.mkv");
  const std::string command =
      fmt::format("ffmpeg -v error -y -i '{}' -itsoffset {} -i '{}' -c copy '{}'",
                  clip.video.string(), late, noise.string(), heard.video.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  heard.timeline = read_timeline(heard.video);
  return heard;
}

std::filesystem::path write_noise(const std::filesystem::path& path) {
  const std::string command = fmt::format(
      "ffmpeg -v error -y -f lavfi -i anoisesrc=d=1:seed=7:r=16000 '{}'", path.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return path;
}

// The bounds are those of failure mode A12. The one camera that films 1.7 frames late; a clip
// without motion stays, with a warning. Catches: the sign of the offset; neighbouring frames
// for paths exchanged (before, after); offsets of pairs not joined.
TEST(SyncMotion, OneShiftedCameraOfARig) {
  const ScratchFolder folder;
  make_rig(folder / "rig", {0, 0, 0, 1.7});
  std::vector<RigClip> clips = clips_of(folder / "rig");
  const size_t count = clips.size();
  clips.push_back(still_clip(clips[0], folder / "still.mp4"));
  const ClipClocks clocks = by_motion(clips);
  const std::vector<double> frames = frames_of(clocks, clips);
  for (size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(frames[i], i == 3 ? 1.7 : 0, i == 3 ? 0.1 : 0.05) << text_of(frames);
    EXPECT_EQ(clocks.clocks[i].source, "motion");
  }
  EXPECT_EQ(frames[count], 0);
  EXPECT_EQ(clocks.clocks[count].source, "none");
  EXPECT_GE(clocks.clocks[count].uncertainty, 0.5);
  ASSERT_EQ(clocks.warnings.size(), 1u);
  EXPECT_NE(clocks.warnings[0].find("cam09"), std::string::npos);
  EXPECT_NE(clocks.warnings[0].find("--offsets"), std::string::npos);
}

// A synchronised rig of which one camera's sound is 0.17 s late: the pictures win, with a warning,
// and all clocks stay within 0.05 frame (failure mode A12). Catches: sound taken whenever it
// is confident; the start time of the sound track ignored (no contradiction is seen).
TEST(SyncMotion, SoundThatContradictsThePicturesIsNotTaken) {
  const ScratchFolder folder;
  make_rig(folder / "rig", {});
  std::vector<RigClip> clips = clips_of(folder / "rig");
  const auto noise = write_noise(folder / "noise.wav");
  for (size_t i = 0; i < clips.size(); ++i)
    clips[i] = with_sound(clips[i], noise, i == 2 ? 0.17 : 0);
  const ClipClocks heard = synchronise(clips, {SyncMethod::kAudio, {}}, {});
  for (size_t i = 0; i < clips.size(); ++i)  // a time stamp of Matroska is a millisecond
    EXPECT_NEAR(heard.clocks[i].offset, i == 2 ? -0.17 : 0, 1.1e-3);
  const ClipClocks clocks = synchronise(clips, {}, {});
  for (const double frames : frames_of(clocks, clips)) EXPECT_NEAR(frames, 0, 0.05);
  ASSERT_EQ(clocks.warnings.size(), 1u);
  EXPECT_NE(clocks.warnings[0].find("cam02"), std::string::npos);
  EXPECT_NE(clocks.warnings[0].find("sound"), std::string::npos);
}

// Clocks of rigs of one's own, in frames: TESSERA_SYNC_RIGS="DIR DIR" sync_test
// --gtest_filter='*Report*'.
TEST(SyncMotion, ReportOfGivenRigs) {
  const char* folders = std::getenv("TESSERA_SYNC_RIGS");
  if (folders == nullptr) GTEST_SKIP() << "TESSERA_SYNC_RIGS names no folder of videos";
  std::stringstream list(folders);
  for (std::string folder; list >> folder;) {
    std::vector<RigClip> clips = clips_of(folder);
    const ClipClocks clocks = by_motion(clips);
    fmt::print("{}\n  measured {}\n  applied  {}\n  errors   {}\n", folder,
               text_of(frames_of(clocks, clips)),
               text_of(frames_of(clocks, clips, &ClipClock::offset)),
               text_of(frames_of(clocks, clips, &ClipClock::uncertainty)));
    for (const std::string& warning : clocks.warnings) fmt::print("  {}\n", warning);
  }
}

}  // namespace
}  // namespace tessera
