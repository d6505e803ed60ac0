// FTGS and sogst PLY: what is written is evaluated by a reader that knows the specifications alone,
// what is read back is as it was, and files that others write are read as they mean them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <sstream>

#include "ingest/files/atomic_file.h"
#include "static3d/transform/slicer.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/static3d/line_motion/some_clip.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

/// A file of float columns and comments, read without the program's reader.
struct Table {
  std::map<std::string, std::string> comments;
  std::vector<std::string> names;
  std::vector<std::map<std::string, double>> rows;

  explicit Table(const std::filesystem::path& path) {
    const std::string text = read_text_file(path);
    const size_t body = text.find("end_header\n") + 11;
    std::istringstream lines(text.substr(0, body));
    size_t count = 0;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string first, second, third;
      words >> first >> second >> third;
      if (first == "comment") comments[second] = third;
      if (first == "element") count = std::stoul(third);
      if (first == "property") names.push_back(third);
    }
    EXPECT_EQ(text.size(), body + 4 * count * names.size());
    for (size_t r = 0; r < count; ++r) {
      rows.emplace_back();
      for (size_t c = 0; c < names.size(); ++c) {
        float value = 0;
        std::memcpy(&value, text.data() + body + 4 * (r * names.size() + c), 4);
        rows.back()[names[c]] = double(value);
      }
    }
  }
  double number(const std::string& key) const { return std::stod(comments.at(key)); }
};

/// A Gaussian at a time: place and opacity.
struct Seen {
  double x, y, z, opacity;
};

/// α and position by the text of ftgs-player, t in 0 … 1.
Seen by_ftgs(const Table& file, const std::map<std::string, double>& row, double t) {
  const double dt = t - row.at("time");
  const double life = std::max(std::exp(row.at("log_duration")), file.number("min_duration"));
  const double base = 1 / (1 + std::exp(-row.at("opacity")));
  return {row.at("x") + row.at("velocity_0") * dt, row.at("y") + row.at("velocity_1") * dt,
          row.at("z") + row.at("velocity_2") * dt,
          std::max(base * std::exp(-0.5 * dt * dt / life / life), file.number("opacity_floor"))};
}

/// The same by section 1 of the .sogst format, with its seconds.
Seen by_sogst(const Table& file, const std::map<std::string, double>& row, double t) {
  const double seconds = file.number("sogst.time_min") +
                         t * (file.number("sogst.time_max") - file.number("sogst.time_min"));
  const double dt = seconds - row.at("t_center");
  const double sigma = row.at("t_sigma");
  return {row.at("x") + row.at("vx") * dt, row.at("y") + row.at("vy") * dt,
          row.at("z") + row.at("vz") * dt,
          std::exp(-0.5 * (dt / sigma) * (dt / sigma)) / (1 + std::exp(-row.at("opacity")))};
}

class LinePly : public ::testing::Test {
 protected:
  std::filesystem::path at(const char* extension) const {
    return folder / (std::string("a") + extension);
  }
  ScratchFolder folder;
};

// Bugs put back, each seen to fail: σ of .sogst as its logarithm; velocities of .sogst per clip;
// static Gaussians with σ of one clip.
TEST_F(LinePly, IsEvaluatedByTheSpecificationAsWeDraw) {
  const GaussianModel model = some_clip();
  const Slicer slicer(model);
  for (const char* extension : {".ftgs.ply", ".sogst.ply"}) {
    SCOPED_TRACE(extension);
    save_lines(at(extension), model, 24);
    const Table file(at(extension));
    ASSERT_EQ(file.rows.size(), 10u);
    const bool is_ftgs = std::string(extension) == ".ftgs.ply";
    for (const double t : {0.0, 0.3, 0.77, 1.0}) {
      for (size_t n = 0; n < 3; ++n) {
        const Seen seen =
            is_ftgs ? by_ftgs(file, file.rows[n], t) : by_sogst(file, file.rows[n], t);
        EXPECT_NEAR(seen.x, model.static_set.values().at(kMean, int64_t(n))[0], 1e-6);
        EXPECT_NEAR(seen.opacity,
                    sigmoid(double(*model.static_set.values().at(kOpacityLogit, int64_t(n)))),
                    1e-6);
      }
      for (const MovingGaussian& moving : slicer.moving()) {
        const auto& row = file.rows[size_t(3 + moving.source)];
        const Seen seen = is_ftgs ? by_ftgs(file, row, t) : by_sogst(file, row, t);
        const double dt = t - double(*model.dynamic_set.values().at(kMeanTime, moving.source));
        const float* const v = model.dynamic_set.values().at(kVelocity, moving.source);
        EXPECT_NEAR(seen.x, double(moving.mean.x) + v[0] * dt, 1e-5);
        EXPECT_NEAR(seen.z, double(moving.mean.z) + v[2] * dt, 1e-5);
        const double fade = std::exp(-0.5 * dt * dt * double(moving.spacetime.precision_time));
        EXPECT_NEAR(seen.opacity, double(moving.opacity) * fade, 1e-5);
      }
    }
  }
  EXPECT_EQ(Table(at(".ftgs.ply")).comments.at("n_frames"), "121");
  EXPECT_EQ(Table(at(".sogst.ply")).comments.at("sogst.fps"), "24");
}

// In the order of the specification, and with all 45 coefficients or none.
TEST_F(LinePly, HasTheColumnsOfItsSpecification) {
  save_lines(at(".sogst.ply"), some_clip(4));
  std::vector<std::string> names = Table(at(".sogst.ply")).names;
  const std::vector<std::string> base{"x",       "y",      "z",        "rot_0",   "rot_1",
                                      "rot_2",   "rot_3",  "scale_0",  "scale_1", "scale_2",
                                      "opacity", "f_dc_0", "f_dc_1",   "f_dc_2",  "vx",
                                      "vy",      "vz",     "t_center", "t_sigma", "f_rest_0"};
  ASSERT_EQ(names.size(), 64u);
  EXPECT_EQ(names.back(), "f_rest_44");
  names.resize(base.size());
  EXPECT_EQ(names, base);
  save_lines(at(".sogst.ply"), some_clip(1));
  EXPECT_EQ(Table(at(".sogst.ply")).names.size(), 19u);
  save_lines(at(".ftgs.ply"), some_clip(4));
  EXPECT_EQ(Table(at(".ftgs.ply")).names.size(), 22u + 9u);
  EXPECT_EQ(Table(at(".ftgs.ply")).comments.at("sh_degree"), "1");
}

// Bug put back: rules of drawing are those of other programs; seen to fail.
TEST_F(LinePly, IsReadBackAsItWas) {
  for (const int coefficients : {1, 9, 16})
    for (const char* extension : {".ftgs.ply", ".sogst.ply"}) {
      SCOPED_TRACE(extension);
      const GaussianModel model = some_clip(coefficients);
      save_lines(at(extension), model);
      ASSERT_TRUE(is_line_file(at(extension)));
      const LineFile file = load_line_file(at(extension));
      EXPECT_TRUE(file.warnings.empty());
      const GaussianModel& read = file.model;
      EXPECT_TRUE(read.drawing.filter_2d);
      EXPECT_EQ(read.drawing.near_plane, 0.125);
      EXPECT_EQ(read.background, model.background);
      EXPECT_NEAR(read.time_axis.origin, 2, 1e-12);
      EXPECT_NEAR(read.time_axis.duration, 5, 1e-12);
      ASSERT_EQ(read.static_set.count(), 3);
      ASSERT_EQ(read.dynamic_set.count(), 7);
      for (const auto& [a, b] : {std::pair(&model.static_set, &read.static_set),
                                 std::pair(&model.dynamic_set, &read.dynamic_set)})
        for (int g = 0; g < a->groups(); ++g)
          for (int64_t n = 0; n < a->count(); ++n)
            for (int k = 0; k < a->width(Group(g)); ++k) {
              const float value = a->values().at(Group(g), n)[k];
              EXPECT_NEAR(b->values().at(Group(g), n)[k], value, 2e-6 * (1 + std::abs(value)));
            }
    }
}

/// One row without normals, whose SH degree is 0.
std::string ftgs_by_hand(const std::string& comments, float log_duration) {
  std::string text = "ply\nformat ascii 1.0\n" + comments + "element vertex 1\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0",
                           "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "time",
                           "log_duration", "velocity_0", "velocity_1", "velocity_2"})
    text += fmt::format("property float {}\n", name);
  return text +
         fmt::format("end_header\n1 2 3 0 0 0 1 -3 -3 -3 1 0 0 0 0.25 {} 4 5 6\n", log_duration);
}

TEST_F(LinePly, OfOthersIsReadAsTheyMeanIt) {
  const std::string comments =
      "comment ftgs_version 1\ncomment time_units normalized\ncomment sh_degree 0\n"
      "comment use_velocity 1\ncomment min_duration 0.02\ncomment opacity_floor 0.0001\n";
  write_text_file(at(".ply"), ftgs_by_hand(comments, -9));
  GaussianModel read = load_line_file(at(".ply")).model;
  ASSERT_EQ(read.dynamic_set.count(), 1);
  EXPECT_NEAR(*read.dynamic_set.values().at(kLogScaleTime, 0), std::log(0.02), 1e-6);
  EXPECT_NEAR(read.time_axis.duration, 299 / 30.0, 1e-9) << "no n_frames";
  EXPECT_FALSE(read.drawing.filter_2d);
  std::string still = ftgs_by_hand(comments + "comment n_frames 31\n", 5);
  still.replace(still.find("use_velocity 1"), 14, "use_velocity 0");
  write_text_file(at(".ply"), still);
  read = load_line_file(at(".ply")).model;
  EXPECT_EQ(read.static_set.count(), 1) << "neither moves nor fades";
  EXPECT_NEAR(read.time_axis.duration, 1, 1e-9);
  EXPECT_FALSE(read.time_axis.is_stated) << "of 30 frames a second, which no file states";
  const auto expect_refused = [&](const std::string& from, const std::string& to,
                                  const char* part) {
    std::string text = ftgs_by_hand(comments, 0);
    text.replace(text.find(from), from.size(), to);
    write_text_file(at(".ply"), text);
    expect_input_error([&] { load_line_file(at(".ply")); }, {at(".ply").string(), part});
  };
  expect_refused("ftgs_version 1", "ftgs_version 2", "version 2");
  expect_refused("min_duration 0.02", "min_duration 0", "min_duration 0");
  expect_refused("comment use_velocity 1\n", "", "no comment 'use_velocity'");
  expect_refused("property float time\n", "property float tame\n", "'time'");
}

// Bug put back: the comments are taken where a sidecar stands beside them; seen to fail.
TEST_F(LinePly, OfSogstNeedsItsSecondsAndASidecarWins) {
  save_lines(at(".sogst.ply"), some_clip(1));
  write_text_file(folder / "a.sogst.sogst.json", R"({"time_min": 2, "time_max": 12, "fps": 30})");
  GaussianModel read = load_line_file(at(".sogst.ply")).model;
  EXPECT_EQ(read.time_axis.duration, 10);
  EXPECT_NEAR(*read.dynamic_set.values().at(kMeanTime, 6), 0.5, 1e-6);
  std::filesystem::remove(folder / "a.sogst.sogst.json");
  EXPECT_EQ(load_line_file(at(".sogst.ply")).model.time_axis.duration, 5);
  std::string text = read_text_file(at(".sogst.ply"));
  const size_t place = text.find("comment sogst.time_max");
  text.erase(place, text.find('\n', place) + 1 - place);
  write_text_file(at(".sogst.ply"), text);
  expect_input_error([&] { load_line_file(at(".sogst.ply")); },
                     {at(".sogst.ply").string(), "sogst.time_max"});
}

}  // namespace
}  // namespace tessera::testing
