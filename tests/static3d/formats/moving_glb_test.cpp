// The .glb of a whole clip: its document is what glTF demands, and its nodes, posed at a time, put
// the Gaussians where the model has them.
#include "static3d/formats/moving_glb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/math/rotation3.h"
#include "static3d/transform/slicer.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/travelling_camera.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

struct GlbRead {
  json document;
  std::string buffer;

  explicit GlbRead(const std::filesystem::path& path) {
    const std::string file = read_text_file(path);
    ByteReader bytes(file, path);
    EXPECT_EQ(bytes.take(4), "glTF");
    EXPECT_EQ(bytes.number<uint32_t>(), 2u);
    EXPECT_EQ(bytes.number<uint32_t>(), file.size());
    const auto text = bytes.number<uint32_t>();
    bytes.take(4);
    document = json::parse(bytes.take(text));
    const auto size = bytes.number<uint32_t>();
    bytes.take(4);
    buffer = bytes.take(size);
    EXPECT_EQ(bytes.left(), 0u);
  }
  const json& accessor(const json& index) const {
    return document["accessors"].at(index.get<size_t>());
  }
  std::vector<float> floats(const json& index) const {
    const json& view = document["bufferViews"].at(accessor(index)["bufferView"].get<size_t>());
    std::vector<float> values(view["byteLength"].get<size_t>() / sizeof(float));
    std::memcpy(values.data(), buffer.data() + view["byteOffset"].get<size_t>(),
                values.size() * sizeof(float));
    return values;
  }
  const json& attributes(size_t mesh) const {
    return document["meshes"][mesh]["primitives"][0]["attributes"];
  }
  /// A channel's value at `seconds`; empty where there is no such channel. Rotations are blended
  /// and normalised, which differs from slerp by less than the tests see.
  std::vector<float> value(size_t node, const std::string& path, float seconds) const {
    if (!document.contains("animations")) return {};
    const json& animation = document["animations"][0];
    for (const json& channel : animation["channels"]) {
      if (channel["target"]["node"] != node || channel["target"]["path"] != path) continue;
      const json& sampler = animation["samplers"].at(channel["sampler"].get<size_t>());
      const std::vector<float> times = floats(sampler["input"]), keys = floats(sampler["output"]);
      const size_t width = keys.size() / times.size();
      size_t i = 0;
      while (i + 1 < times.size() && times[i + 1] <= seconds) ++i;
      std::vector<float> result(keys.begin() + std::ptrdiff_t(i * width),
                                keys.begin() + std::ptrdiff_t((i + 1) * width));
      if (sampler["interpolation"] == "STEP" || i + 1 == times.size()) return result;
      const float f = std::max(0.0f, (seconds - times[i]) / (times[i + 1] - times[i]));
      for (size_t k = 0; k < width; ++k) result[k] += f * (keys[(i + 1) * width + k] - result[k]);
      return result;
    }
    return {};
  }
  /// Means of all meshes that are shown at a time, in the world of the model.
  std::vector<Vec3<double>> means(float seconds) const {
    std::vector<Vec3<double>> result;
    for (size_t n = 0; n < document["nodes"].size(); ++n) {
      const json& node = document["nodes"][n];
      if (!node.contains("mesh")) continue;
      std::vector<float> t = value(n, "translation", seconds), q = value(n, "rotation", seconds);
      const std::vector<float> s = value(n, "scale", seconds);
      if (!s.empty() && s[0] == 0) continue;
      if (t.empty()) t = {0, 0, 0};
      if (q.empty()) q = {0, 0, 0, 1};
      const Mat3<double> turn = rotation_matrix(normalised(Vec4<double>(q[3], q[0], q[1], q[2])));
      const std::vector<float> x = floats(attributes(node["mesh"].get<size_t>())["POSITION"]);
      for (size_t i = 0; i < x.size(); i += 3) {
        const Vec3<double> p = turn * Vec3<double>(x[i], x[i + 1], x[i + 2]);
        result.push_back({-(p[0] + double(t[0])), -(p[1] + double(t[1])), p[2] + double(t[2])});
      }
    }
    return result;
  }
};

double nearest(const std::vector<Vec3<double>>& means, const float* x) {
  double least = INFINITY;
  for (const Vec3<double>& m : means)
    least = std::min(least, glm::length(m - Vec3<double>(x[0], x[1], x[2])));
  return least;
}

/// A body that turns about an axis between x and z, moves and is carried by one node.
GaussianModel turning_askew() {
  GaussianModel model = turning_truth(2, {0.3, 0, 0.2});
  Buffer<float>& rotation = model.nodes.rotation.value;
  for (int64_t i = 0; i < rotation.size(); i += 4) {
    rotation[i + 1] = 0.6f * rotation[i + 3];
    rotation[i + 3] *= 0.8f;
  }
  return model;
}

GaussianModel with_dynamic() {
  GaussianModel model = turning_truth(2, {0.3, 0, 0.2});
  model.dynamic_set = random_model(0, 30, 5, 1, SetForm::kVelocity).dynamic_set.clone_values();
  return model;
}

// Bugs put back: half a turn about z left out of node translations; of node rotations; members in
// world coordinates. Each seen to fail.
TEST(MovingGlb, ARigidModelIsWhereItsSliceIs) {
  const ScratchFolder folder;
  GaussianModel model = turning_askew();
  model.time_axis = {4, 2.0};
  const MovingGlbReport report = save_moving_glb(folder / "a.glb", model, 30);
  EXPECT_EQ(report.groups, 1);
  EXPECT_EQ(report.keys, 61);
  EXPECT_EQ(report.gaussians, model.static_set.count());
  EXPECT_LT(report.rms_motion_error, 1e-5);
  const GlbRead read(folder / "a.glb");
  for (const double time : {0.0, 0.21, 0.5, 0.77, 1.0}) {
    const std::vector<Vec3<double>> means = read.means(float(2 * time));
    const GaussianSet slice = Slicer(model).at(time);
    ASSERT_EQ(means.size(), size_t(slice.count()));
    // between keys 1/60 of the clip apart the chord of a turn by 1/30 rad is off by 1e-4 · radius
    for (int64_t n = 0; n < slice.count(); ++n)
      EXPECT_LT(nearest(means, slice.values().at(kMean, n)), 4e-4) << time << " " << n;
  }
}

// Bugs put back: no bounds of keyframe times; scale keys LINEAR; the first key of scale left out.
// Each seen to fail.
TEST(MovingGlb, TheDocumentIsWhatGltfDemands) {
  const ScratchFolder folder;
  const MovingGlbReport report = save_moving_glb(folder / "a.glb", with_dynamic(), 30);
  const GlbRead read(folder / "a.glb");
  const json& d = read.document;
  EXPECT_EQ(d["extensionsUsed"], json::array({"KHR_gaussian_splatting"}));
  EXPECT_EQ(d["nodes"][0]["children"].size(), size_t(report.groups));
  int64_t gaussians = 0;
  for (size_t m = 0; m < d["meshes"].size(); ++m) {
    const json& primitive = d["meshes"][m]["primitives"][0];
    EXPECT_EQ(primitive["mode"], 0);
    EXPECT_EQ(primitive["extensions"]["KHR_gaussian_splatting"]["kernel"], "ellipse");
    const json& position = read.accessor(read.attributes(m)["POSITION"]);
    EXPECT_EQ(position["min"].size(), 3u);
    EXPECT_EQ(position["max"].size(), 3u);
    for (const char* name : {"ROTATION", "SCALE", "OPACITY", "SH_DEGREE_0_COEF_0"})
      EXPECT_EQ(read.accessor(
                    read.attributes(m).at(std::string("KHR_gaussian_splatting:") + name))["count"],
                position["count"]);
    gaussians += position["count"].get<int64_t>();
  }
  EXPECT_EQ(gaussians, report.gaussians);
  const json& animation = d["animations"][0];
  for (const json& channel : animation["channels"]) {
    const json& node = d["nodes"].at(channel["target"]["node"].get<size_t>());
    EXPECT_TRUE(node.contains("mesh"));
    const json& sampler = animation["samplers"].at(channel["sampler"].get<size_t>());
    EXPECT_EQ(sampler["interpolation"], channel["target"]["path"] == "scale" ? "STEP" : "LINEAR");
    const std::vector<float> times = read.floats(sampler["input"]);
    ASSERT_GE(times.size(), 2u);
    EXPECT_EQ(times[0], 0);
    for (size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i], times[i - 1]);
    EXPECT_EQ(read.accessor(sampler["input"])["count"], read.accessor(sampler["output"])["count"]);
    ASSERT_TRUE(read.accessor(sampler["input"]).contains("min"));
    EXPECT_EQ(read.accessor(sampler["input"])["max"][0], times.back());
  }
}

// Bugs put back: node translation of a velocity per second; means not at the group's time. Each
// seen to fail.
TEST(MovingGlb, DynamicGaussiansAreAtTheirMeansWhileTheyLast) {
  const ScratchFolder folder;
  GaussianModel model = random_model(5, 400, 5, 1, SetForm::kVelocity);
  model.time_axis.duration = 2;
  EXPECT_LE(save_moving_glb(folder / "a.glb", model, 30).groups, 256);
  const GlbRead read(folder / "a.glb");
  const Slicer slicer(model);
  int64_t seen = 0, exact = 0;
  for (const MovingGaussian& g : slicer.moving()) {
    const float time = g.spacetime.mean_time;
    if (g.source % 8 != 0 || time < 0 || time > 1) continue;  // reading takes its time
    ++seen;
    exact += nearest(read.means(2 * time), &g.mean[0]) < 1e-5;
  }
  EXPECT_GT(seen, 20);
  // all but those whose group appears later or has disappeared before
  EXPECT_GT(double(exact), 0.95 * double(seen));
}

}  // namespace
}  // namespace tessera::testing
