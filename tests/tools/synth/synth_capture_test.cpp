// Captures on disk: D-NeRF folders, truth, refusals, complete output or none, equal bytes for equal
// seeds.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/files/ply.h"
#include "ingest/files/png.h"
#include "kernels/base/errors.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"
#include "tools/synth/sensor.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A folder of its own for each test, removed after it.
class SynthCapture : public ::testing::Test {
 protected:
  SynthCapture() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) /
              ("synth_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~SynthCapture() override { fs::remove_all(folder_); }

  fs::path folder_;
};

SynthOptions tiny_dnerf() {
  SynthOptions options;
  options.scene = SynthScene::kObject;
  options.layout = SynthLayout::kDnerf;
  options.frames = 6;
  options.held_out_frames = 3;
  options.width = 48;
  options.height = 40;
  options.points = 500;
  return options;
}

std::map<std::string, std::string> all_bytes(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[fs::relative(entry.path(), folder).string()] = read_text_file(entry.path());
  return files;
}

std::string error_of(const SynthOptions& options, const fs::path& out) {
  try {
    make_capture(options, out, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// Seen to fail: two rows of the pose exchanged; a val split with train's count.
TEST_F(SynthCapture, DnerfFolderHasItsSplitsPosesAndImages) {
  const SynthReport report = make_capture(tiny_dnerf(), folder_ / "toy", {});
  EXPECT_EQ(report.cameras, 1);
  EXPECT_EQ(report.images, 12);
  std::set<std::string> poses;
  for (const auto& [split, count] :
       std::map<std::string, int>{{"train", 6}, {"val", 3}, {"test", 3}}) {
    const json file = json::parse(read_text_file(folder_ / ("toy/transforms_" + split + ".json")));
    ASSERT_EQ(file["frames"].size(), size_t(count));
    const double angle = file["camera_angle_x"];
    double before = -1;
    for (const json& frame : file["frames"]) {
      EXPECT_NEAR(frame["fl_x"].get<double>(), 24 / std::tan(0.5 * angle), 1e-9);
      EXPECT_EQ(frame["cx"], 24.0);
      EXPECT_EQ(frame["cy"], 20.0);
      EXPECT_GT(frame["time"].get<double>(), before);
      before = frame["time"];
      poses.insert(frame["transform_matrix"].dump());
      const json& m = frame["transform_matrix"];  // D-NeRF: above, 4 away, looking at the origin
      EXPECT_GT(m[2][3].get<double>(), 0);
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(m[i][3].get<double>(), 4 * m[i][2].get<double>(), 1e-9);
      EXPECT_NEAR(m[2][0].get<double>(), 0, 1e-12) << "right is level";
      EXPECT_GT(m[2][1].get<double>(), 0) << "up is up";
      const auto axis = [&](int k) {
        return glm::dvec3(m[0][k].get<double>(), m[1][k].get<double>(), m[2][k].get<double>());
      };
      EXPECT_NEAR(glm::dot(glm::cross(axis(0), axis(1)), axis(2)), 1, 1e-9) << "right-handed";
      const std::string path = frame["file_path"];
      const Image8 image = read_png(folder_ / "toy" / (path + ".png"));
      EXPECT_EQ(image.channels, 4);
      EXPECT_EQ(image.width, 48);
      EXPECT_EQ(image.data[3], 0) << "the corner is empty";
      EXPECT_EQ(image.data[size_t(4 * (22 * 48 + 24) + 3)], 255) << "the middle is the toy";
    }
    EXPECT_LE(before, 1);
  }
  EXPECT_EQ(poses.size(), 12u);
}

// Seen to fail: masks numbered from 1; frames of the visitor counted one late.
TEST_F(SynthCapture, TruthNamesMasksTimesAndLifetimes) {
  SynthOptions options = tiny_dnerf();
  options.scene = SynthScene::kRoom;
  options.frames = 21;
  options.fps = {30000, 1001};
  make_capture(options, folder_ / "room", {});
  const json truth = json::parse(read_text_file(folder_ / "room/ground_truth.json"));
  EXPECT_EQ(truth["scene"], "room");
  EXPECT_EQ(truth["seed"], 1);
  EXPECT_EQ(truth["cameras"].size(), 27u);
  EXPECT_EQ(truth["times"][20], 1.0);
  EXPECT_NEAR(truth["times_seconds"][20].get<double>(), 20 * 1001 / 30000.0, 1e-12);
  ASSERT_EQ(truth["appearing"].size(), 1u);
  EXPECT_EQ(truth["appearing"][0]["frames"], json({6, 7, 8, 9, 10, 11, 12}));
  for (const json& camera : truth["cameras"]) {
    char name[64];
    std::snprintf(name, sizeof(name), "mask_%s_%03d.png",
                  camera["split"].get<std::string>().c_str(), camera["index"].get<int>());
    const Image8 mask = read_png(folder_ / "room/ground_truth" / name);
    EXPECT_EQ(mask.channels, 1);
    EXPECT_TRUE(std::set<uint8_t>(mask.data.begin(), mask.data.end()) ==
                (std::set<uint8_t>{0, 255}))
        << name;
  }
}

// Each point lies on a surface: a ray to it from some camera stops there, within float rounding.
// Seen to fail: points 1 % beyond the surface.
TEST_F(SynthCapture, PointsLieOnStaticSurfaces) {
  SynthOptions options = tiny_dnerf();
  options.scene = SynthScene::kRoom;
  make_capture(options, folder_ / "room", {});
  const PlyFile file = read_ply(folder_ / "room/ground_truth/points.ply");
  const PlyElement* vertex = file.find("vertex");
  ASSERT_NE(vertex, nullptr);
  ASSERT_EQ(vertex->rows, 500);
  const synth::World world = synth::build_world(SynthScene::kRoom, 1, 0);
  const auto solids = synth::place(world, synth::Part::kStatic, 0);
  const glm::dvec3 inside(0.1, -2.6, 1.4);
  int seen = 0;
  for (size_t i = 0; i < 500; ++i) {
    const glm::dvec3 p(vertex->find("x")->values[i], vertex->find("y")->values[i],
                       vertex->find("z")->values[i]);
    const synth::Meeting meeting = synth::cast({inside, p - inside}, solids);
    EXPECT_LT(meeting.hit.depth, 1 + 1e-5);  // nothing lies behind a surface of a closed room
    seen += meeting.hit.depth > 1 - 1e-5;
  }
  EXPECT_GT(seen, 350);  // the others are hidden from this place
}

// Seen to fail: the world's seed ignored; frame noise from a running counter.
TEST_F(SynthCapture, BytesFollowFromTheSeed) {
  SynthOptions options = tiny_dnerf();
  options.noise_sigma = 2;
  options.exposure_wobble = 0.05;
  make_capture(options, folder_ / "a", {});
  make_capture(options, folder_ / "b", {});
  const auto a = all_bytes(folder_ / "a"), b = all_bytes(folder_ / "b");
  EXPECT_EQ(a.size(), 12u + 12u + 3u + 2u);
  EXPECT_TRUE(a == b);
  options.seed = 2;
  make_capture(options, folder_ / "b", {});  // replaces its own earlier capture
  const auto other = all_bytes(folder_ / "b");
  EXPECT_NE(a.at("train/r_000.png"), other.at("train/r_000.png"));
  EXPECT_NE(a.at("ground_truth/points.ply"), other.at("ground_truth/points.ply"));
  const Camera camera = synth::look_at({3, -3, 2}, {0, 0, 0}, 48, 40, 0.7);
  const auto image = [&](uint64_t seed) {
    return synth::render(synth::build_world(SynthScene::kObject, seed, 0), camera, 0, 1).rgba;
  };
  EXPECT_EQ(image(1), image(1));
  EXPECT_NE(image(1), image(2));
}

// Seen to fail: sigma taken as a share of 1, one noise for all frames.
TEST(SynthSensor, NoiseAndExposureAreAsAsked) {
  SynthOptions options;
  options.noise_sigma = 3;
  const synth::RenderedImage grey{200, 100, std::vector<float>(80000, 0.5f),
                                  std::vector<uint8_t>(20000)};
  const Image8 first = synth::expose(grey, options, 3, 0, 0);
  const Image8 second = synth::expose(grey, options, 3, 0, 1);
  double sum = 0, squares = 0, product = 0;
  for (size_t i = 0; i < first.data.size(); ++i) {
    const double a = first.data[i] - 63.75, b = second.data[i] - 63.75;  // half over black: 0.25
    sum += a;
    squares += a * a;
    product += a * b;
  }
  const double n = double(first.data.size());
  EXPECT_NEAR(sum / n, 0, 0.06);
  EXPECT_NEAR(std::sqrt(squares / n), 3, 0.1);
  EXPECT_NEAR(product / n, 0, 0.2);
  options.exposure_wobble = 0.1;
  double least = 2, most = 0;
  for (int frame = 0; frame < 50; ++frame) {
    const double gain = synth::exposure_gain(options, 1, frame);
    least = std::min(least, gain);
    most = std::max(most, gain);
  }
  EXPECT_TRUE(least >= 0.9 && least < 0.93 && most > 1.07 && most <= 1.1) << least << " " << most;
}

// Seen to fail: the check of `frames` removed (a folder appears).
TEST_F(SynthCapture, BadOptionsAreRefusedInOneLine) {
  const std::map<std::string, void (*)(SynthOptions&)> wrongs{
      {"cameras", [](SynthOptions& o) { o.cameras = 0; }},
      {"frames", [](SynthOptions& o) { o.frames = 0; }},
      {"width", [](SynthOptions& o) { o.width = -4; }},
      {"fps", [](SynthOptions& o) { o.fps.denominator = 0; }},
      {"supersampling", [](SynthOptions& o) { o.supersampling = 0; }},
      {"noise_sigma", [](SynthOptions& o) { o.noise_sigma = NAN; }},
      {"odd",
       [](SynthOptions& o) {
         o.layout = SynthLayout::kN3dv;
         o.height = 41;
       }},
  };
  for (const auto& [word, spoil] : wrongs) {
    SynthOptions options = tiny_dnerf();
    spoil(options);
    const std::string message = error_of(options, folder_ / "never");
    EXPECT_NE(message.find(word), std::string::npos) << word << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_FALSE(fs::exists(folder_ / "never"));
  }
  EXPECT_NE(error_of(tiny_dnerf(), ""), "");
}

// Seen to fail: writing straight into `out`.
TEST_F(SynthCapture, FolderAppearsWholeOrNotAtAll) {
  fs::create_directories(folder_ / "mine");
  write_text_file(folder_ / "mine/thesis.txt", "precious");
  EXPECT_NE(error_of(tiny_dnerf(), folder_ / "mine"), "");
  EXPECT_EQ(read_text_file(folder_ / "mine/thesis.txt"), "precious");

  make_capture(tiny_dnerf(), folder_ / "toy/", {});
  const auto before = all_bytes(folder_ / "toy");
  const auto stop = [](std::string_view, int64_t done, int64_t) {
    if (done == 5) throw std::runtime_error("stopped");
  };
  SynthOptions other = tiny_dnerf();
  other.seed = 9;
  EXPECT_THROW(make_capture(other, folder_ / "toy", stop), std::runtime_error);
  EXPECT_TRUE(all_bytes(folder_ / "toy") == before);
  int64_t entries = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) entries += entry.exists();
  EXPECT_EQ(entries, 2) << "a temporary folder was left behind";

  write_text_file(folder_ / "file", "");
  EXPECT_NE(error_of(tiny_dnerf(), folder_ / "file/inside"), "");
}

// Seen to fail: a find that returns the first row whatever the name.
TEST(SynthTables, EveryNameFindsItsRow) {
  for (const SynthSceneRow& row : synth_scenes()) {
    EXPECT_EQ(find_synth_scene(row.name), row.scene);
    EXPECT_EQ(name_of(row.scene), row.name);
    EXPECT_FALSE(row.doc.empty());
  }
  for (const SynthLayoutRow& row : synth_layouts()) {
    EXPECT_EQ(find_synth_layout(row.name), row.layout);
    EXPECT_EQ(name_of(row.layout), row.name);
  }
  EXPECT_FALSE(find_synth_scene("kitchen"));
}

}  // namespace
}  // namespace tessera
