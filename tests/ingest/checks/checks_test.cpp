// The scene checks that need no features (times, leakage, cloud, coverage), each on a scene with
// its fault and on one without. Checks with features are tested in feature_checks_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ingest/checks/cloud_health.h"
#include "ingest/checks/coverage.h"
#include "ingest/checks/leakage.h"
#include "ingest/checks/orientation.h"
#include "ingest/checks/time_range.h"
#include "tests/ingest/checks/checks_fixture.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

bool has(const Findings& findings, Severity severity, const std::string& check,
         const std::string& camera = "") {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
    return finding.severity == severity && finding.check == check &&
           (camera.empty() || finding.camera == camera);
  });
}

// What nothing speaks against is no warning. Finds a finding for each camera of a rig.
TEST(Checks, ClocksThatAreNotKnownAreNamed) {
  Scene scene = ring_scene({.cameras = 6, .timesteps = 31});
  scene.time_axis.duration = 1;  // 30 frames a second
  const Findings findings = check_clocks(scene, {{"cam0", "motion", 0, 0.001},
                                                 {"cam1", "motion", 0, 0.02},
                                                 {"cam2", "motion", 0.05, 0.02},
                                                 {"cam3", "none", 0, 0.5},
                                                 {"cam4", "none", 0, 0}});
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].severity, Severity::kWarning);
  EXPECT_EQ(findings[0].measured,
            "the clocks of cam3 could not be measured; there are offsets of up to 0.050 s");
  EXPECT_EQ(findings[1].measured,
            "the clocks of cam1 (± 0.60 frames), cam2 (± 0.60 frames) are known roughly; there are "
            "offsets of up to 0.050 s");
  const Findings calm = check_clocks(scene, {{"cam0", "motion", 0, 0.001}, {"cam3", "none", 0, 1}});
  ASSERT_EQ(calm.size(), 1u);
  EXPECT_EQ(calm[0].severity, Severity::kInfo);
  EXPECT_EQ(calm[0].measured,
            "the clocks of cam3 could not be measured; they are taken as they are");
}

// Fails without the search for steps that are longer than the median one.
TEST(Checks, GapsAndOtherRanges) {
  Scene scene = ring_scene({.cameras = 4, .timesteps = 11});
  EXPECT_FALSE(has(check_times(scene).findings, Severity::kWarning, "time"));
  Scene gap = scene;
  std::erase_if(gap.frames, [](const Frame& f) {
    return f.camera_name == "cam1" && (f.frame_number == 4 || f.frame_number == 5);
  });
  const SceneTimes times = check_times(gap);
  EXPECT_TRUE(has(times.findings, Severity::kWarning, "time", "cam1"));
  EXPECT_EQ(times.cameras[1].missing, 2);
  Scene late = scene;
  std::erase_if(late.frames,
                [](const Frame& f) { return f.camera_name == "cam2" && f.frame_number < 3; });
  EXPECT_TRUE(has(check_times(late).findings, Severity::kWarning, "time", "cam2"));
}

// The frames of another rate that are nearest to few timesteps, and those of a higher rate between
// the first and the last of the others. Bugs put back, each seen to fail: 2 % of the clip for any
// distance of frames; the camera's own distance alone.
TEST(Checks, AnotherRateIsNoOtherRange) {
  Scene scene = ring_scene({.cameras = 4, .timesteps = 5});
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam1") frame.time = 0.03 + 0.92 * frame.time;
  EXPECT_FALSE(has(check_times(scene).findings, Severity::kWarning, "time"));
  scene = ring_scene({.cameras = 4, .timesteps = 21});
  std::erase_if(scene.frames, [](const Frame& frame) {
    const bool is_end = frame.frame_number == 0 || frame.frame_number == 20;
    return frame.camera_name == "cam1" ? is_end : frame.frame_number % 2 == 1;
  });
  EXPECT_FALSE(has(check_times(scene).findings, Severity::kWarning, "time"));
}

/// Turns the camera about its viewing direction.
void roll(Scene& scene, const std::string& camera, double degrees) {
  const double c = std::cos(degrees * 3.14159265358979 / 180);
  const double s = std::sin(degrees * 3.14159265358979 / 180);
  const glm::dmat3 turn(c, s, 0, -s, c, 0, 0, 0, 1);  // by columns
  for (Frame& frame : scene.frames)
    if (frame.camera_name == camera) {
      frame.camera.cam_from_world = turn * frame.camera.cam_from_world;
      frame.camera.translation = turn * frame.camera.translation;
    }
}

// Bugs put back, each seen to fail: the first camera's up direction taken for the rig's; angles
// without their sign; photos, of which one is held upright, judged as a rig.
TEST(Checks, CamerasOnTheirSide) {
  Scene scene = ring_scene({.cameras = 6, .timesteps = 3});
  for (int c = 0; c < 6; ++c) roll(scene, "cam" + std::to_string(c), c % 2 == 0 ? 15 : -15);
  EXPECT_TRUE(check_orientation(scene).findings.empty());
  roll(scene, "cam0", 75);
  roll(scene, "cam3", -75);
  roll(scene, "cam4", 165);
  const OrientationCheck check = check_orientation(scene);
  ASSERT_EQ(check.findings.size(), 3u);
  for (const char* camera : {"cam0", "cam3", "cam4"})
    EXPECT_TRUE(has(check.findings, Severity::kWarning, "turned", camera)) << camera;
  EXPECT_NEAR(std::abs(check.cameras[0].degrees), 90, 20);  // "up" is a mean of tilted cameras
  EXPECT_GT(check.cameras[0].degrees, 0);
  EXPECT_LT(check.cameras[3].degrees, 0);
  EXPECT_NE(check.findings[0].measured.find("against 3 of 6 cameras"), std::string::npos);
  EXPECT_NE(check.findings[2].measured.find("upside down"), std::string::npos);
  EXPECT_NE(check.findings[0].measured.find("turned clockwise by"), std::string::npos);
  EXPECT_NE(check.findings[1].measured.find("turned anticlockwise by"), std::string::npos);
  EXPECT_EQ(check.findings[1].measured.find("-"), std::string::npos) << "a turn has no sign";
  const char* const back[] = {"-vf transpose=2 ", "-vf transpose=1 ", "-vf hflip,vflip "};
  for (size_t i = 0; i < 3; ++i)
    EXPECT_NE(check.findings[i].advice.find(back[i]), std::string::npos)
        << check.findings[i].advice;
  std::erase_if(scene.frames, [](const Frame& frame) { return frame.frame_number > 0; });
  EXPECT_TRUE(check_orientation(scene).findings.empty());
}

TEST(Checks, ImagesOfMixedShape) {
  const std::vector<std::string> names{"a", "b", "c"};
  EXPECT_EQ(mixed_orientation(names, {{640, 360}, {360, 640}, {640, 360}}),
            "b is higher than wide (360x640), 2 others are wider than high");
  EXPECT_EQ(mixed_orientation(names, {{640, 360}, {640, 480}, {300, 300}}), "");
  EXPECT_EQ(mixed_orientation(names, {{360, 640}, {360, 640}, {360, 640}}), "");
}

// B18. Fails with images compared by name, or poses without their timesteps.
TEST(Checks, Leakage) {
  const ScratchFolder folder;
  Scene scene = ring_scene({.cameras = 3, .timesteps = 2});
  for (Frame& frame : scene.frames)
    if (frame.camera_name == "cam0") frame.split = Split::kTest;
  std::vector<std::filesystem::path> files = write_images(scene, folder.path());
  const Leakage clean = check_leakage(scene, files);
  EXPECT_FALSE(has(clean.findings, Severity::kError, "leakage"));
  EXPECT_EQ(clean.training_frames, 4);
  std::filesystem::copy_file(files[2], files[0], std::filesystem::copy_options::overwrite_existing);
  EXPECT_EQ(check_leakage(scene, files).same_images, 1);
  EXPECT_TRUE(has(check_leakage(scene, files).findings, Severity::kError, "leakage", "cam0"));
  Scene same = scene;
  same.frames[0].camera = same.frames[2].camera;  // timestep 0 of cam0 and cam1
  EXPECT_EQ(check_leakage(same, files).same_views, 1);
  EXPECT_NE(check_leakage(same, files).training_manifest, "");
  same.frames[0].timestep = 7;  // another timestep is no leak
  EXPECT_EQ(check_leakage(same, files).same_views, 0);
}

// B6. Fails with colours compared to chance the other way round, and without the flip being seen.
TEST(Checks, CloudOfAnotherConvention) {
  Scene scene = ring_scene({.cameras = 8, .timesteps = 1, .size = 64});
  scene.points = coloured_sphere(2000);
  paint_points(scene);
  const CloudHealth good = check_cloud(scene);
  EXPECT_LT(good.colour_ratio, 0.5);
  EXPECT_FALSE(has(good.findings, Severity::kError, "cloud"));
  for (glm::vec3& p : scene.points.position) p = {p.x, -p.y, -p.z};  // OpenGL for OpenCV
  const CloudHealth flipped = check_cloud(scene);
  EXPECT_GT(flipped.colour_ratio, 0.8);
  EXPECT_TRUE(has(flipped.findings, Severity::kError, "cloud"));
}

// Fails with any of the counts left out.
TEST(Checks, CloudCounts) {
  Scene scene = ring_scene({.cameras = 6, .timesteps = 1});
  EXPECT_TRUE(has(check_cloud(scene).findings, Severity::kWarning, "cloud"));  // none
  scene.points = coloured_sphere(100);
  scene.points.position[0].x = std::nanf("");
  scene.points.position[1] = scene.points.position[2];
  scene.points.position[3] = {1e5f, 0, 0};
  const CloudHealth health = check_cloud(scene);
  EXPECT_EQ(health.not_finite, 1);
  EXPECT_EQ(health.duplicates, 1);
  EXPECT_EQ(health.far, 1);
  EXPECT_TRUE(has(health.findings, Severity::kError, "cloud"));
}

// B12: few cameras warn, and others do not.
TEST(Checks, FewCamerasAndAloneCamera) {
  EXPECT_TRUE(has(check_coverage(ring_scene({.cameras = 4, .timesteps = 1})).findings,
                  Severity::kWarning, "coverage"));
  Scene scene = ring_scene({.cameras = 6, .timesteps = 1});
  scene.points = coloured_sphere(500);
  const CoverageCheck good = check_coverage(scene);
  EXPECT_FALSE(has(good.findings, Severity::kWarning, "coverage"));
  EXPECT_EQ(good.seen_by_one + good.seen_by_none, 0);  // the whole sphere is in every image
  // points behind cam0's back, where cam3 alone looks: a tenth of the cloud
  for (int i = 0; i < 50; ++i) scene.points.position[size_t(i)] = {20.0f, 0.01f * float(i), 0};
  const CoverageCheck part = check_coverage(scene);
  EXPECT_DOUBLE_EQ(part.seen_by_one, 0.1);
  EXPECT_DOUBLE_EQ(part.alone[3], 0.1);
}

}  // namespace
}  // namespace tessera::testing
