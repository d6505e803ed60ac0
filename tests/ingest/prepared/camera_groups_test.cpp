// Cameras of frames by folders, views and names, on made-up frames: rigs in one folder, moving
// rigs, moving cameras, and names that say nothing or the wrong thing.
#include "ingest/prepared/camera_groups.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <set>

namespace tessera {
namespace {

using Name = std::function<std::string(int camera, int step)>;
using Frames = std::vector<UngroupedFrame>;

constexpr int kRigCameras = 4, kRigSteps = 5;

/// The frame as transforms_json.cpp lists it: its camera is its folder.
UngroupedFrame frame_of(const std::string& name, double time, int view) {
  const std::string folder = name.substr(0, name.rfind('/'));
  return {name, folder.substr(folder.rfind('/') + 1), false, Split::kTrain, time, view};
}

/// Cameras that film together. A moving rig has a view a frame; `late`: clock of a camera.
Frames rig(const Name& name, bool moves = false, double late = 0) {
  Frames frames;
  for (int step = 0; step < kRigSteps; ++step)
    for (int camera = 0; camera < kRigCameras; ++camera)
      frames.push_back(frame_of(name(camera, step), step + late * camera,
                                moves ? step * kRigCameras + camera : camera));
  return frames;
}

Frames shuffled(Frames frames) {
  std::shuffle(frames.begin(), frames.end(), std::mt19937(3));
  return frames;
}

/// The names of the frames of each camera.
std::map<std::string, std::set<std::string>> members(const Frames& frames,
                                                     const CameraGroups& groups) {
  std::map<std::string, std::set<std::string>> found;
  for (size_t i = 0; i < frames.size(); ++i) found[groups.cameras[i]].insert(frames[i].name);
  return found;
}

std::string cameras_of(const Frames& frames) {
  std::string text;
  for (const auto& [camera, names] : members(frames, group_cameras(frames)))
    text += (text.empty() ? "" : " ") + camera;
  return text;
}

std::string flat(int camera, int step) {
  return fmt::format("images/cam{:02}_{:04}", camera, step);
}
std::string folders(int camera, int step) {
  return fmt::format("cam{:02}/{:04}", camera, step);
}
std::string counted(int camera, int step) {
  return fmt::format("images/{:04}", camera * kRigSteps + step);
}

// Bug put back: the folder as the camera (no group_cameras); seen to fail.
TEST(CameraGroups, NamesInOneFolderAreThoseOfFolders) {
  for (const bool moves : {false, true}) {
    const Frames frames = shuffled(rig(flat, moves));
    const CameraGroups groups = group_cameras(frames);
    EXPECT_TRUE(groups.regrouped);
    for (const auto& [camera, names] : members(frames, groups)) {
      EXPECT_EQ(names.size(), size_t(kRigSteps));
      for (const std::string& name : names) EXPECT_EQ(name.substr(7, 5), camera);
    }
    EXPECT_EQ(groups.note, "read as 4 cameras with 5 images each, by the names of their images");
    EXPECT_EQ(cameras_of(rig(folders, moves)), "cam00 cam01 cam02 cam03");
    EXPECT_FALSE(group_cameras(rig(folders, moves)).regrouped);
  }
}

TEST(CameraGroups, CamerasAreFoundInManyKindsOfNames) {
  const Name names[] = {
      [](int c, int t) { return fmt::format("images/{:04}_cam{}", t, c); },
      [](int c, int t) { return fmt::format("images/{:04}_{:02}", t, c); },
      [](int c, int t) { return fmt::format("{:04}/cam{}", t, c); },
      [](int c, int t) { return fmt::format("rig/{}/images/{:04}", "abcd"[c], t); },
      [](int c, int t) {
        return fmt::format("{}/cam{}_{:04}", c / 2 ? "left" : "right", c % 2, t);
      },
  };
  const char* cameras[] = {"cam0 cam1 cam2 cam3", "00 01 02 03", "cam0 cam1 cam2 cam3", "a b c d",
                           "left_cam0 left_cam1 right_cam0 right_cam1"};
  for (size_t k = 0; k < std::size(names); ++k)
    for (const bool moves : {false, true})
      EXPECT_EQ(cameras_of(rig(names[k], moves)), cameras[k]) << names[k](1, 2);
}

// Bug put back: names that say nothing keep the folder; seen to fail.
TEST(CameraGroups, ViewsAreCamerasWhereNamesSayNothing) {
  const Frames frames = rig(counted), other = shuffled(frames);
  EXPECT_EQ(cameras_of(frames), "camera_0 camera_1 camera_2 camera_3");
  EXPECT_EQ(members(frames, group_cameras(frames)), members(other, group_cameras(other)));
  EXPECT_EQ(group_cameras(frames).cameras[1], "camera_1");
  EXPECT_EQ(members(frames, group_cameras(rig(counted, false, 1e-9))),
            members(frames, group_cameras(frames)));
  const CameraGroups alone = group_cameras(rig(counted, true));
  EXPECT_EQ(std::set<std::string>(alone.cameras.begin(), alone.cameras.end()).size(),
            size_t(kRigCameras * kRigSteps));
  EXPECT_NE(alone.note.find("neither poses nor names"), std::string::npos) << alone.note;
}

// Bug put back: fit() without scattered(); seen to fail.
TEST(CameraGroups, ViewsDecideAgainstNames) {
  for (const auto& named : {flat, folders}) {
    const Frames frames = rig([&](int camera, int step) {
      return named(step % 2 == 0 ? camera : kRigCameras - 1 - camera, step);
    });
    const CameraGroups groups = group_cameras(frames);
    for (size_t i = 0; i < frames.size(); ++i)
      EXPECT_EQ(groups.cameras[i], groups.cameras[size_t(frames[i].view)]);
    EXPECT_NE(groups.note.find("by their poses, which their names do not tell"), std::string::npos)
        << groups.note;
  }
}

TEST(CameraGroups, ClocksThatDifferLeaveTheCameras) {
  for (const bool moves : {false, true})
    for (const double late : {1e-9, 0.05, 0.3}) {
      EXPECT_EQ(cameras_of(rig(flat, moves, late)), "cam00 cam01 cam02 cam03") << late;
      EXPECT_EQ(cameras_of(rig(folders, moves, late)), "cam00 cam01 cam02 cam03") << late;
    }
}

// Bug put back: views that come again are fixed cameras whatever the names; seen to fail.
TEST(CameraGroups, OneImageATimeIsOneMovingCamera) {
  for (const int views : {1000, 30, 12, 5, 1}) {  // a path, a closed loop, jumps, one view
    Frames frames;
    for (int i = 0; i < 31; ++i)
      frames.push_back(frame_of(fmt::format("train/r_{:03}", i), i / 30.0, i % views));
    for (int i = 0; i < 7; ++i) {
      frames.push_back(frame_of(fmt::format("test/r_{:03}", i), i / 6.0, i % views));
      frames.back().split = Split::kTest;
    }
    EXPECT_FALSE(group_cameras(frames).regrouped) << views;
    EXPECT_EQ(cameras_of(frames), "test train") << views;
  }
}

TEST(CameraGroups, TwoClipsOfOneCameraStayOne) {
  Frames frames;
  for (int i = 0; i < 20; ++i)
    frames.push_back(frame_of(fmt::format("images/clip{}_{:03}", i / 10, i % 10), i, i));
  EXPECT_EQ(cameras_of(frames), "images");
}

TEST(CameraGroups, FixedCamerasAndOneThatMoves) {
  Frames frames = rig(flat);
  for (int i = 0; i < kRigSteps; ++i)
    frames.push_back(frame_of(fmt::format("images/head_{:04}", i), i, 100 + i));
  EXPECT_EQ(cameras_of(frames), "cam00 cam01 cam02 cam03 head");
  frames = rig(counted);
  for (int i = 0; i < kRigSteps; ++i)
    frames.push_back(frame_of(fmt::format("images/{:04}", 100 + i), i, 100 + i));
  EXPECT_EQ(cameras_of(frames), "camera_0 camera_1 camera_2 camera_3 camera_4");
}

TEST(CameraGroups, SplitsShareTimesAndCameras) {
  Frames frames = rig(flat);
  for (UngroupedFrame& frame : frames)
    if (frame.view == 0 || frame.time > 3) frame.split = Split::kTest;
  EXPECT_EQ(cameras_of(frames), "cam00 cam01 cam02 cam03");
}

// Keys of entries come before names; a number that all entries have (of one lens) says nothing.
TEST(CameraGroups, KeysOfEntriesTellCameras) {
  for (const bool moves : {false, true}) {
    Frames frames = shuffled(rig(counted, moves));
    for (UngroupedFrame& frame : frames) frame.camera = "1";
    EXPECT_EQ(group_cameras(frames).note.find("entries"), std::string::npos);
    for (UngroupedFrame& frame : frames)
      frame.camera = std::string(1, "abcd"[frame.view % kRigCameras]);
    EXPECT_EQ(cameras_of(frames), "a b c d");
  }
}

TEST(CameraGroups, StatedCamerasStay) {
  Frames frames = rig(counted);
  for (UngroupedFrame& frame : frames)
    if (frame.view == 0) {
      frame.listing = "camera_1";
      frame.stated = true;
    }
  EXPECT_EQ(cameras_of(frames), "camera_0 camera_1 camera_2 camera_3");
  for (UngroupedFrame& frame : frames) frame.time = 7;
  EXPECT_EQ(cameras_of(frames), "camera_1 images") << "all times equal";
}

}  // namespace
}  // namespace tessera
