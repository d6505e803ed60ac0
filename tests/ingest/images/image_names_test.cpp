// Cameras and frame numbers in the names of files and folders.
#include "ingest/images/image_names.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

// Bug put back: the letter between word and number not taken; seen to fail.
TEST(ImageNames, CamerasAreCalledSo) {
  for (const char* name : {"cam00", "Camera_B1", "3", "00_12", "c7", "V2", "hd-4", "GoPro 12",
                           "sensor_a12-123", "cama1", "cn12345"})
    EXPECT_TRUE(is_camera_name(name)) << name;
  for (const char* name : {"", "cam", "images_4", "123456", "cam__1", "camab1", "1_1234", "photo3",
                           "c_1", "cam1_", "1cam", "cam1.2"})
    EXPECT_FALSE(is_camera_name(name)) << name;
}

struct Stem {
  const char* stem;
  const char* camera;
  int64_t number;
};

// Bugs put back, each seen to fail: the case of the camera not kept; nine digits of a longer
// number; a word of frames taken away after any letter.
TEST(ImageNames, StemsAreCameraAndNumber) {
  for (const auto& [stem, camera, number] :
       {Stem{"cam00_0012", "cam00", 12}, Stem{"0012_Cam03", "Cam03", 12},
        Stem{"frame_7-view_b2", "view_b2", 7}, Stem{"img0001", "", 1}, Stem{"IMG_0042", "", 42},
        Stem{"c1t5", "c1", 5}, Stem{"shot5", "shot", 5}, Stem{"camera_3_img_0001", "camera_3", 1},
        Stem{"Left - Frame 09", "Left", 9}, Stem{"1764000000866666667", "", 1764000000866666667},
        Stem{"cam1_12345678901234567890", "", -1}, Stem{"12_view", "", -1}, Stem{"cover", "", -1},
        Stem{"", "", -1}, Stem{"0001_cam", "", -1}, Stem{"00-cam12345", "00-cam", 12345}}) {
    const auto name = parse_stem(stem);
    ASSERT_EQ(name.has_value(), number >= 0) << stem;
    if (!name) continue;
    EXPECT_EQ(name->camera, camera) << stem;
    EXPECT_EQ(name->number, number) << stem;
  }
}

}  // namespace
}  // namespace tessera
