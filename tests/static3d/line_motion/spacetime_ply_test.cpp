// Files of SpacetimeGaussians: images of what is read are near those of the formulas of the paper,
// at each time; what cannot be read is named.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "kernels/math/spherical_harmonics.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/lines.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/carried_model.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

using Row = std::map<std::string, double>;

/// By the order of the columns that its program writes.
std::vector<std::string> column_names() {
  std::vector<std::string> names{"x", "y", "z", "trbf_center", "trbf_scale", "nx", "ny", "nz"};
  const auto add = [&](const char* name, int count) {
    for (int i = 0; i < count; ++i) names.push_back(fmt::format("{}_{}", name, i));
  };
  add("motion", 9);
  add("f_dc", 3);
  names.push_back("opacity");
  add("scale", 3);
  add("rot", 4);
  add("omega", 4);
  return names;
}

/// Of Gaussians about the origin that bend by some of their sizes and turn.
std::vector<Row> some_rows(size_t count, double bend) {
  Random random(5);
  std::vector<Row> rows(count);
  for (Row& row : rows) {
    for (const std::string& name : column_names()) row[name] = random.uniform(-0.8, 0.8);
    for (int i = 0; i < 9; ++i) row[fmt::format("motion_{}", i)] *= bend;
    for (int i = 0; i < 3; ++i) {
      row[fmt::format("scale_{}", i)] = std::log(random.uniform(0.05, 0.12));
      row[fmt::format("f_dc_{}", i)] = random.uniform(0.1, 0.9);
    }
    row["rot_0"] += 2;
    row["trbf_center"] = random.uniform(-0.1, 1.1);
    row["trbf_scale"] = std::log(random.uniform(0.1, 1.5));
    row["opacity"] = random.uniform(-1, 3);
  }
  return rows;
}

void write_rows(const std::filesystem::path& path, const std::vector<Row>& rows) {
  PlyElement vertex{"vertex", int64_t(rows.size()), {}};
  for (const auto& [name, value] : rows[0]) {
    vertex.columns.push_back({name, PlyType::kFloat32, {}});
    for (const Row& row : rows) vertex.columns.back().values.push_back(row.at(name));
  }
  write_ply(path, {{}, {vertex}});
}

/// At a time by the formulas of the paper: what stands there then.
GaussianModel by_the_paper(const std::vector<Row>& rows, double time) {
  GaussianModel model;
  model.static_set = GaussianSet(SetForm::kStatic, 1);
  model.static_set.resize(int64_t(rows.size()));
  model.drawing.sh_degree = 0;
  const GaussianSpans<float> to = model.static_set.values();
  for (size_t i = 0; i < rows.size(); ++i) {
    const int64_t n = int64_t(i);
    const auto column = [&](const char* name, int k) {
      return rows[i].at(fmt::format("{}_{}", name, k));
    };
    const double dt = time - rows[i].at("trbf_center");
    const double reach = dt / std::exp(rows[i].at("trbf_scale"));
    const double opacity = std::exp(-reach * reach) / (1 + std::exp(-rows[i].at("opacity")));
    *to.at(kOpacityLogit, n) = float(std::log(opacity / (1 - opacity)));
    for (int k = 0; k < 3; ++k) {
      to.at(kMean, n)[k] =
          float(rows[i].at(std::string(1, "xyz"[k])) + column("motion", k) * dt +
                column("motion", 3 + k) * dt * dt + column("motion", 6 + k) * dt * dt * dt);
      to.at(kLogScale, n)[k] = float(column("scale", k));
      to.at(kSh, n)[k] = float((column("f_dc", k) - 0.5) / kSh0);
    }
    for (int k = 0; k < 4; ++k)
      to.at(kRotation, n)[k] = float(column("rot", k) + column("omega", k) * dt);
  }
  return model;
}

class SpacetimePly : public ::testing::Test {
 protected:
  /// The least PSNR of three views at five times, dB.
  double likeness_to(const std::vector<Row>& rows) {
    write_rows(file, rows);
    read = load_line_file(file);
    double least = 1e9;
    for (const double time : {0.0, 0.2, 0.5, 0.85, 1.0})
      least = std::min(least, likeness(read.model, by_the_paper(rows, time), {time}));
    return least;
  }
  ScratchFolder folder;
  std::filesystem::path file = folder / "point_cloud.ply";
  LineFile read;
};

// Bugs put back, each seen to fail: σ_t of e^s; colours as coefficients.
TEST_F(SpacetimePly, OnLinesIsAsInThePaper) {
  std::vector<Row> rows = some_rows(30, 1);
  for (Row& row : rows) {
    for (int i = 3; i < 9; ++i) row[fmt::format("motion_{}", i)] = 0;
    for (int i = 0; i < 4; ++i) row[fmt::format("omega_{}", i)] = 0;
  }
  EXPECT_GT(likeness_to(rows), 58);
  EXPECT_EQ(read.model.count(), 30);
  EXPECT_EQ(read.warnings, std::vector<std::string>());
  EXPECT_FALSE(read.model.time_axis.is_stated);
}

// Bug put back: motion of the first degree; seen to fail.
TEST_F(SpacetimePly, OnCurvesIsNearThem) {
  const std::vector<Row> rows = some_rows(30, 0.6);
  EXPECT_GT(likeness_to(rows), 32);
  EXPECT_GT(read.model.count(), 100);
  EXPECT_LT(read.model.count(), 1000);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("of 30 Gaussians move along curves and are"), std::string::npos)
      << read.warnings[0];
}

TEST_F(SpacetimePly, WhatIsNotReadIsNamed) {
  std::vector<Row> rows = some_rows(2, 1);
  rows[0]["motion_4"] = std::nan("");
  write_rows(file, rows);
  read = load_line_file(file);
  ASSERT_FALSE(read.warnings.empty());
  EXPECT_NE(read.warnings.back().find("1 of "), std::string::npos) << read.warnings.back();
  rows = some_rows(2, 1);
  for (Row& row : rows) row["f_t_0"] = 1;
  write_rows(file, rows);
  expect_input_error([&] { load_line_file(file); }, {file.string(), "f_t", "lite"});
  rows = some_rows(2, 1);
  for (Row& row : rows) row.erase("omega_2");
  write_rows(file, rows);
  expect_input_error([&] { load_line_file(file); }, {file.string(), "'omega_2'"});
}

}  // namespace
}  // namespace tessera::testing
