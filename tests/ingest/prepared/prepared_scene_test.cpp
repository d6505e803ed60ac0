// Prepared scenes: a scene that is written and loaded is equal to the original, and folders appear
// only when they are complete.
#include "ingest/prepared/prepared_scene.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "ingest/files/fnv1a.h"
#include "ingest/files/folders.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/poses/llff_poses.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/prepared/transforms_json.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;
using tessera::testing::TemporaryFolder;  // and not that of files/folders.h

Capture example_scene() {
  Capture scene;
  scene.layout = "n3dv";
  scene.background = "opaque";
  scene.scale = 0.5;
  scene.time_axis = {1.7e9, 10.0};
  scene.time_base = {1, 12288};
  scene.has_points = true;
  scene.cameras = {{"cam00", {1, 12288}, 0.0}, {"cam01", {1001, 30000}, 0.125}};
  scene.sources = {{"cam00.mp4", "cbf29ce484222325"}};
  for (int i = 0; i < 4; ++i) {
    CaptureFrame prepared;
    Frame& frame = prepared.frame;
    frame.camera_name = i < 2 ? "cam00" : "cam01";
    frame.name = frame.camera_name + "/0000" + std::to_string(i % 2);
    prepared.file_path = frame.name + ".png";
    frame.frame_number = i % 2;
    frame.time = i % 2 == 0 ? 0.25 : 1.0 / 3;  // neither 0 nor 1: a subset of the capture's range
    frame.split = i < 2 ? Split::kTest : Split::kTrain;
    frame.camera = {8, 6, 10.1, 10.2, 4.3, 2.9, {}, {}};
    json matrix = gl_matrix(looking_at_origin({3.0, 1.0 + i, 0.3}));
    PoseRows rows{};
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c) rows[r][c] = matrix[r][c];
    set_pose(frame.camera, rows, "test");
    prepared.ticks = 512 * i;
    scene.frames.push_back(prepared);
  }
  return scene;
}

// Bug put back: times of a prepared scene normalised again on loading; seen to fail (0 and 1).
TEST(PreparedScene, WrittenAndLoadedIsEqual) {
  const TemporaryFolder folder;
  const Capture written = example_scene();
  for (const CaptureFrame& frame : written.frames)
    write_png(folder / frame.file_path, patterned_image(8, 6, 3, int(frame.frame.frame_number)));
  const PointCloud points{
      {{1, 2, 3}, {-1, 0.5f, 1e-7f}}, {{{1, 2, 3}}, {{255, 0, 128}}}, {}, {}, {}};
  write_points(folder / "points.ply", points);
  write_prepared_scene(folder.path(), written);
  EXPECT_TRUE(is_prepared_scene(folder.path()));
  const Scene scene = load_scene(folder.path(), {});
  ASSERT_EQ(scene.frames.size(), 4u);
  EXPECT_EQ(scene.time_axis.origin, 1.7e9);
  EXPECT_EQ(scene.time_axis.duration, 10);
  EXPECT_FALSE(scene.is_static);
  EXPECT_EQ(scene.points.position, points.position);
  EXPECT_EQ(scene.points.colour, points.colour);
  for (size_t i = 0; i < 4; ++i) {
    const Frame &one = written.frames[i].frame, &other = scene.frames[i];
    EXPECT_EQ(one.name, other.name);
    EXPECT_EQ(one.camera_name, other.camera_name);
    EXPECT_EQ(one.frame_number, other.frame_number);
    EXPECT_EQ(one.time, other.time);
    EXPECT_EQ(one.split, other.split);
    expect_same_camera(one.camera, other.camera, 1e-14);
    EXPECT_EQ(other.image.data, patterned_image(8, 6, 3, int(i % 2)).data);
  }
}

// Bugs put back, each seen to fail: all pixels loaded; frames that are not loaded left out, so that
// scores do not know which timesteps were trained on; the other frames of a moving camera loaded.
TEST(PreparedScene, PixelsOfASplitOnly) {
  const TemporaryFolder folder;
  Capture written = example_scene();
  written.has_points = false;
  for (const CaptureFrame& frame : written.frames)
    write_png(folder / frame.file_path, patterned_image(8, 6, 3, int(frame.frame.frame_number)));
  const auto loaded = [&](Split split) {
    write_prepared_scene(folder.path(), written);
    std::string which;
    const Scene scene = load_scene(folder.path(), {.pixels_of = std::vector{split}});
    EXPECT_EQ(scene.frames.size(), 4u);
    for (const Frame& frame : scene.frames) {
      EXPECT_EQ(frame.image.width, 8);
      which += frame.image.data.empty() ? '-' : '+';
    }
    return which;
  };
  EXPECT_EQ(loaded(Split::kTest), "++--");
  EXPECT_EQ(loaded(Split::kTrain), "--++");
  EXPECT_EQ(loaded(Split::kVal), "----");
  written.frames[1].frame.split = Split::kTrain;
  EXPECT_EQ(loaded(Split::kTest), "+---") << "the camera moves";
  written.frames[1].frame.camera = written.frames[0].frame.camera;
  EXPECT_EQ(loaded(Split::kTest), "++--") << "it stands still: its median tells what moves";
}

TEST(PreparedScene, ReportsItsOptions) {
  const TemporaryFolder folder;
  write_prepared_scene(folder.path(), example_scene());
  const json file = json::parse(read_bytes(folder / "transforms.json"));
  EXPECT_EQ(file["ply_file_path"], "points.ply");
  const json& tessera = file["tessera"];
  EXPECT_EQ(tessera["format_version"], 1);
  EXPECT_EQ(tessera["applied"]["scale"], 0.5);
  EXPECT_EQ(tessera["applied"]["background"], "opaque");
  EXPECT_EQ(tessera["applied"]["world_transform"][2], (json{0, 0, 1, 0}));
  EXPECT_EQ(tessera["time"]["base"], (json{1, 12288}));
  EXPECT_EQ(tessera["cameras"][1]["time_base"], (json{1001, 30000}));
  EXPECT_EQ(tessera["cameras"][1]["time_offset"], 0.125);
  EXPECT_EQ(tessera["source_hashes_fnv1a64"]["cam00.mp4"], "cbf29ce484222325");
  EXPECT_EQ(file["frames"][3]["tessera"]["camera"], "cam01");
  EXPECT_EQ(file["frames"][3]["tessera"]["ticks"], 1536);
  EXPECT_EQ(file["frames"][3]["split"], "train");
}

TEST(PreparedScene, NewerVersionsAndImpossibleTimesAreRefused) {
  const TemporaryFolder folder;
  Capture scene = example_scene();
  scene.has_points = false;
  for (const CaptureFrame& frame : scene.frames)
    write_png(folder / frame.file_path, patterned_image(8, 6, 3));
  write_prepared_scene(folder.path(), scene);
  const auto with = [&](const std::function<void(json&)>& change, std::vector<std::string> parts) {
    write_prepared_scene(folder.path(), scene);
    edit_json(folder / "transforms.json", change);
    expect_input_error([&] { load_scene(folder.path(), {}); }, parts);
  };
  with([](json& f) { f["tessera"]["format_version"] = 3; }, {"version 3"});
  with([](json& f) { f["tessera"]["time"]["duration"] = 0; }, {"duration is 0"});
  with([](json& f) { f["frames"][2]["time"] = 1.5; }, {"frame 2", "1.5"});
}

TEST(SourceHash, KnownValues) {
  const TemporaryFolder folder;
  write_bytes(folder / "empty", "");
  write_bytes(folder / "a", "foobar");
  EXPECT_EQ(source_hash(folder / "empty"), "cbf29ce484222325");  // the published test vectors
  EXPECT_EQ(source_hash(folder / "a"), "85944171f73967e8");
  expect_input_error([&] { source_hash(folder / "none"); }, {"none", "No such file"});
}

TEST(StagedFolder, AppearsWholeOrNotAtAll) {
  const TemporaryFolder folder;
  {
    const StagedFolder staged(folder / "out", false);
    write_bytes(staged.path() / "half", "x");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  StagedFolder staged(folder / "out/", false);
  write_bytes(staged.path() / "whole", "x");
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  staged.commit();
  EXPECT_EQ(read_bytes(folder / "out/whole"), "x");
}

TEST(StagedFolder, ReplacesOnlyWhatItMay) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "out");
  write_bytes(folder / "out/precious", "x");
  write_bytes(folder / "file", "x");
  expect_input_error([&] { StagedFolder(folder / "out", false); }, {"out", "overwritten"});
  expect_input_error([&] { StagedFolder(folder / "file", true); }, {"file", "expected a folder"});
  expect_input_error([&] { StagedFolder(folder / "file/below", true); }, {"ot a directory"});
  StagedFolder staged(folder / "out", true);
  EXPECT_EQ(read_bytes(folder / "out/precious"), "x");
  staged.commit();
  EXPECT_TRUE(std::filesystem::is_empty(folder / "out"));
}

// Bugs put back: nothing removed; the folder of a living process removed; what another scene's
// process left removed; each seen to fail.
TEST(StagedFolder, RemovesWhatKilledProcessesLeft) {
  const TemporaryFolder folder;
  const pid_t killed = ::fork();
  if (killed == 0) ::_exit(0);
  ASSERT_EQ(::waitpid(killed, nullptr, 0), killed);
  const std::string partial = fmt::format(".out.{}.{}.partial", host_name(), killed);
  const std::string others[] = {fmt::format(".out.{}.{}.partial", host_name(), ::getppid()),
                                fmt::format(".out.elsewhere.{}.partial", killed),
                                fmt::format(".out2.{}.{}.partial", host_name(), killed),
                                fmt::format(".out.{}.x.partial", host_name())};
  for (const std::string& name : others) std::filesystem::create_directories(folder / name);
  std::filesystem::create_directories(folder / partial);
  write_bytes(folder / (partial + "/half"), "x");
  StagedFolder(folder / "out", true);
  EXPECT_FALSE(std::filesystem::exists(folder / partial));
  for (const std::string& name : others) EXPECT_TRUE(std::filesystem::exists(folder / name));
}

TEST(Llff, RoundTripAndBadRows) {
  const TemporaryFolder folder;
  std::vector<LlffPose> poses;
  for (const CaptureFrame& frame : example_scene().frames) {
    Camera camera = frame.frame.camera;
    camera.fl_y = camera.fl_x;
    camera.cx = 4;
    camera.cy = 3;
    poses.push_back({camera, 0.5, 20});
  }
  write_llff_poses(folder / "poses_bounds.npy", poses);
  const auto back = read_llff_poses(folder / "poses_bounds.npy");
  ASSERT_EQ(back.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    expect_same_camera(poses[i].camera, back[i].camera, 1e-14);
    EXPECT_EQ(back[i].far, 20);
  }
  poses[2].camera.fl_x = 0;
  write_llff_poses(folder / "poses_bounds.npy", poses);
  expect_input_error([&] { read_llff_poses(folder / "poses_bounds.npy"); }, {"row 2", "focal"});
}

}  // namespace
}  // namespace tessera
