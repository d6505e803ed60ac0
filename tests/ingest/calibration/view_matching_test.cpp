// The camera of each clip, by name and by number, and what is refused.
#include "ingest/calibration/view_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using Names = std::vector<std::string>;
using ::testing::HasSubstr;

/// Cameras of these names, each with another pose unless `one_pose`.
std::vector<RigCamera> cameras_called(const Names& names, bool one_pose = false) {
  std::vector<RigCamera> cameras;
  for (const std::string& name : names) {
    cameras.push_back({name, {}, {}, "PINHOLE"});
    if (!one_pose) cameras.back().camera.translation = {double(cameras.size()), 0, 0};
  }
  return cameras;
}

/// The names of the cameras that the clips get, "-" where one gets none.
Names matched(const Names& cameras, const Names& clips) {
  const MatchedViews match = match_views(cameras_called(cameras), clips);
  EXPECT_EQ(match.refusal, "");
  Names names;
  for (const auto& place : match.camera) names.push_back(place ? cameras[*place] : "-");
  return names;
}

std::string refusal(const Names& cameras, const Names& clips) {
  const MatchedViews match = match_views(cameras_called(cameras), clips);
  for (const auto& place : match.camera) EXPECT_FALSE(place);
  return match.refusal;
}

// Bug put back: files compared with their extension; seen to fail.
TEST(ViewMatching, ByNameWithoutExtensionAndFolder) {
  const Names clips{"cam00", "cam01"};
  for (const Names& cameras : {Names{"cam01", "cam00"},
                               {"cam01.png", "cam00.png"},
                               {"images/cam01.jpg", "cam00.mp4"},
                               {"cam01/0000.png", "cam00/0000.png"},
                               {"rig\\cam01\\7.png", "rig\\cam00\\7.png"},
                               {"cam01_0000.png", "cam00_0000.png"}}) {
    EXPECT_EQ(matched(cameras, clips), (Names{cameras[1], cameras[0]}));
  }
  EXPECT_EQ(matched({"other", "cam01"}, clips), (Names{"-", "cam01"}));
}

// Bug put back: the number looked for behind the extension; seen to fail.
TEST(ViewMatching, ByNumberOneToOne) {
  EXPECT_EQ(matched({"image1.png", "image10.png", "image2.png"}, {"cam01", "cam02", "cam10"}),
            (Names{"image1.png", "image2.png", "image10.png"}));
  EXPECT_EQ(matched({"v1/a.png", "v2/a.png"}, {"c1", "c2"}), (Names{"v1/a.png", "v2/a.png"}));
  // cam10 has its name, the others their number
  EXPECT_EQ(matched({"cam9", "cam10"}, {"cam09", "cam10"}), (Names{"cam9", "cam10"}));
}

// Bug put back: cameras taken in the order of their numbers; seen to fail.
TEST(ViewMatching, AnOffsetIsNotGuessed) {
  const std::string said = refusal({"image1.png", "image2.png"}, {"cam00", "cam01"});
  for (const char* part : {"cam00, cam01", "image1.png, image2.png", "differ by 1"})
    EXPECT_THAT(said, HasSubstr(part));
  EXPECT_THAT(refusal({"a1", "a2", "a3"}, {"cam1", "cam2"}), HasSubstr("it has a1, a2, a3"));
  EXPECT_THAT(refusal({"left1", "right1"}, {"cam1", "cam2"}), HasSubstr("no camera for"));
  EXPECT_THAT(refusal({"a", "b"}, {"cam1", "cam2"}), HasSubstr("no camera for"));
}

// Bugs put back, each seen to fail: the first of two clips that a name means; the assignments not
// compared.
TEST(ViewMatching, WhereRulesDifferNoneIsTaken) {
  EXPECT_THAT(refusal({"cam1/cam2.png", "cam2/cam1.png"}, {"cam1", "cam2"}),
              HasSubstr("'cam1/cam2.png' names cam2 and cam1"));
  const std::string said = refusal({"v1/2.png", "v2/1.png"}, {"cam1", "cam2"});
  EXPECT_THAT(said, HasSubstr("by one rule"));
  EXPECT_THAT(said, HasSubstr("it has v1/2.png, v2/1.png"));
}

// Bug put back: the poses of a clip's images not compared; seen to fail.
TEST(ViewMatching, ImagesOfOneClipMustHaveOnePose) {
  const Names clips{"cam0", "cam1"};
  EXPECT_THAT(refusal({"cam0/0.png", "cam0/1.png", "cam1/0.png"}, clips),
              HasSubstr("its 2 images of cam0 have different poses: a camera that moves"));
  auto cameras = cameras_called({"cam0/0.png", "cam0/1.png"}, true);
  cameras.push_back(cameras_called({"x", "cam1/0.png"})[1]);
  const MatchedViews match = match_views(cameras, clips);
  EXPECT_EQ(match.refusal, "");
  EXPECT_EQ(match.camera[0], 0u);
  EXPECT_EQ(match.camera[1], 2u);
}

}  // namespace
}  // namespace tessera
