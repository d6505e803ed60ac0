// Compressed .ply, .spz and .splat: written files are read back within their quanta, third-party
// files are read, broken ones are refused. Source: failure modes E2, E6.
#include "static3d/formats/splat_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "ingest/files/gzip.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "static3d/transform/world_change.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/static3d/formats/splat_comparison.h"
#include "tests/support/data_folder.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

std::vector<SplatFormat> read_formats() {
  std::vector<SplatFormat> formats;
  for (const SplatFormat& format : splat_formats())
    if (is_built(format)) formats.push_back(format);
#ifdef TESSERA_HAS_ZSTD
  formats.push_back(spz_format(4));
#endif
  return formats;
}

// Bugs put back, each seen to fail: rotation as x,y,z,w in the compressed file; axes not flipped in
// .spz; q rounded down in .splat.
TEST(SplatFiles, AreReadBackWithinTheirQuanta) {
  const std::map<std::string, Quanta> quanta = {
      {"ply", {0, 0, 1e-7, 0, 0, 1e-6}},
      // ranges of one chunk: about 2 units, 4 of ln scale, 2 of colour
      {"compressed", {2e-3, 4e-3, 0.002, 0.015, 0.032, 0.006}},
      // SH: half of one of 16 parts of 2, of what was rounded to 1/128 before
      {"spz", {1.3e-4, 0.032, 0.002, 0.014, 0.0665, 0.004}},
      // ranges: 3 of ln(1 + |mean|); SH: of splats that share an entry, see sog_test.cpp
      {"sog", {2e-4, 0.02, 0.002, 0.02, 2, 0.0097}},
      {"splat", {0, 1e-5, 0.002, 0.007, 0, 0.03}},
      {"glb", {0, 1e-5, 1e-6, 0, 0, 1e-6}},
  };
  const ScratchFolder folder;
  const GaussianSet set = set_to_write(300);
  for (const SplatFormat& format : read_formats())
    for (int degree : {0, 3}) {
      SCOPED_TRACE(format.name);
      const std::filesystem::path path = folder / (std::string("a") + format.extension);
      EXPECT_EQ(save_splat_file(format, path, set, {degree}), 0);
      const SplatFile read = load_splat_file(path);
      EXPECT_EQ(read.drawing.sh_degree, std::string(format.name) == "splat" ? 0 : degree);
      EXPECT_TRUE(read.warnings.empty()) << read.warnings.front();
      expect_within(set, read.set, quanta.at(format.name));
    }
}

// Bugs put back, each seen to fail: no bit in .spz; the comment of Postshot not read.
TEST(SplatFiles, SayWhetherTheyAreAntialiased) {
  const ScratchFolder folder;
  for (const SplatFormat& format : read_formats())
    for (const bool antialiased : {false, true}) {
      SCOPED_TRACE(format.name);
      const std::filesystem::path path = folder / (std::string("a") + format.extension);
      save_splat_file(format, path, set_to_write(3), {1, antialiased});
      const bool is_held = antialiased && format.has_mark;
      const SplatFile read = load_splat_file(path);
      EXPECT_EQ(read.drawing.antialiased, is_held);
      EXPECT_EQ(model_of(load_splat_file(path)).drawing.filter_2d, is_held);
    }
  save_splat_file(splat_format("ply"), folder / "a.ply", set_to_write(3), {0, true});
  const std::string marked = read_text_file(folder / "a.ply");
  const std::string mark = "SplatRenderMode: mip";
  for (const auto& [comment, antialiased] :
       {std::pair("antialiased 1", true), std::pair("antialiased 0", false),
        std::pair("SPLATRENDERMODE:  MIP ", true), std::pair("SplatRenderMode: default", false),
        std::pair("SplatRenderMode: mip\ncomment antialiased 0", false)}) {
    std::string text = marked;
    text.replace(text.find(mark), mark.size(), comment);
    write_text_file(folder / "a.ply", text);
    EXPECT_EQ(load_splat_file(folder / "a.ply").drawing.antialiased, antialiased) << comment;
  }
}

// A quaternion and a colour written by hand are read with the intended values. Values at the
// ends of their ranges, opacities that round to 0 and 255, an empty set.
TEST(SplatFiles, HoldWhatIsExtreme) {
  const ScratchFolder folder;
  GaussianSet set = set_to_write(4);
  const GaussianSpans<float> values = set.values();
  *values.at(kOpacityLogit, 0) = 40;
  *values.at(kOpacityLogit, 1) = -40;
  for (int k = 0; k < 4; ++k) values.at(kRotation, 2)[k] = k == 1 ? -1.0f : 0.0f;
  for (int k = 0; k < 3; ++k) values.at(kSh, 3)[k] = k == 0 ? 5.0f : -5.0f;
  values.at(kMean, 3)[0] = -2000.5f;
  for (const SplatFormat& format : read_formats()) {
    SCOPED_TRACE(format.name);
    const std::filesystem::path path = folder / (std::string("a") + format.extension);
    const int64_t left_out = save_splat_file(format, path, set, {3});
    EXPECT_EQ(left_out, std::string(format.name) == "compressed" ? 1 : 0) << "the far one";
    const SplatFile read = load_splat_file(path);
    ASSERT_EQ(read.set.count(), 4 - left_out);
    for (const float x : read.set.group(kOpacityLogit).value.span()) EXPECT_TRUE(std::isfinite(x));
    save_splat_file(format, path, GaussianSet(SetForm::kStatic, 16), {3});
    const bool has_header = std::string(format.name) != "splat";
    if (has_header) {
      EXPECT_EQ(load_splat_file(path).set.count(), 0);
    }
  }
}

// Bug put back: the sign of xyz left out; seen to fail.
TEST(SplatFiles, FlippedAxesShowTheSameColours) {
  for (const AxisSigns& s : {kRightUpBack, kLeftUpFront}) {
    GaussianSet set = set_to_write(5), flipped = set.clone_values();
    flip_axes(flipped, s);
    const glm::dvec3 d = glm::normalize(glm::dvec3(0.3, -0.7, 0.64));
    double plain[16], turned[16];
    sh_basis(3, Vec3<double>(d), plain);
    sh_basis(3, Vec3<double>(d.x * s.x, d.y * s.y, d.z * s.z), turned);
    for (int64_t n = 0; n < 5; ++n)
      for (int c = 0; c < 3; ++c) {
        double a = 0, b = 0;
        for (int i = 0; i < 16; ++i) {
          a += plain[i] * double(set.values().at(kSh, n)[3 * i + c]);
          b += turned[i] * double(flipped.values().at(kSh, n)[3 * i + c]);
        }
        EXPECT_NEAR(a, b, 1e-12);
      }
    flip_axes(flipped, s);
    EXPECT_TRUE(same_bits(set, flipped));
  }
}

/// Floats of an attribute of the only primitive.
std::vector<float> attribute(const nlohmann::json& document, std::string_view buffer,
                             const std::string& name) {
  const nlohmann::json& primitive = document["meshes"][0]["primitives"][0];
  const nlohmann::json& accessor =
      document["accessors"][primitive["attributes"].at(name).get<size_t>()];
  const nlohmann::json& view = document["bufferViews"][accessor["bufferView"].get<size_t>()];
  std::vector<float> values(view["byteLength"].get<size_t>() / sizeof(float));
  std::memcpy(values.data(), buffer.data() + view["byteOffset"].get<size_t>(),
              values.size() * sizeof(float));
  return values;
}

// Bug put back: w first in ROTATION; seen to fail.
TEST(SplatFiles, GlbHasChunksAndColumnsOfTheExtension) {
  const ScratchFolder folder;
  const GaussianSet set = set_to_write(7);
  EXPECT_EQ(save_splat_file(splat_format("glb"), folder / "a.glb", set, {2}), 0);
  const std::string file = read_text_file(folder / "a.glb");
  ByteReader bytes(file, "a.glb");
  EXPECT_EQ(bytes.take(4), "glTF");
  EXPECT_EQ(bytes.number<uint32_t>(), 2u);
  EXPECT_EQ(bytes.number<uint32_t>(), file.size());
  const auto text_bytes = bytes.number<uint32_t>();
  EXPECT_EQ(bytes.take(4), "JSON");
  const auto document = nlohmann::json::parse(bytes.take(text_bytes));
  const auto buffer_bytes = bytes.number<uint32_t>();
  EXPECT_EQ(bytes.take(4), std::string_view("BIN\0", 4));
  const std::string_view buffer = bytes.take(buffer_bytes);
  EXPECT_EQ(bytes.left(), 0u);
  const std::string name = "KHR_gaussian_splatting";
  EXPECT_EQ(document["extensionsUsed"][0], name);
  EXPECT_EQ(document["accessors"].size(), 14u) << "5 columns and 9 coefficients";
  const GaussianSpans<const float> values = set.values();
  const std::vector<float> mean = attribute(document, buffer, "POSITION");
  const std::vector<float> rotation = attribute(document, buffer, name + ":ROTATION");
  const std::vector<float> scale = attribute(document, buffer, name + ":SCALE");
  const std::vector<float> opacity = attribute(document, buffer, name + ":OPACITY");
  const std::vector<float> last = attribute(document, buffer, name + ":SH_DEGREE_2_COEF_4");
  ASSERT_EQ(mean.size(), 21u);
  for (size_t n = 0; n < 7; ++n) {
    const auto i = int64_t(n);
    EXPECT_EQ(mean[3 * n], -values.at(kMean, i)[0]);
    EXPECT_EQ(mean[3 * n + 2], values.at(kMean, i)[2]);
    // a half turn about z changes the signs of x and y
    EXPECT_EQ(rotation[4 * n], -values.at(kRotation, i)[1]);
    EXPECT_EQ(rotation[4 * n + 3], values.at(kRotation, i)[0]);
    EXPECT_FLOAT_EQ(scale[3 * n + 1], std::exp(values.at(kLogScale, i)[1]));
    EXPECT_FLOAT_EQ(opacity[n], sigmoid(*values.at(kOpacityLogit, i)));
    EXPECT_EQ(last[3 * n + 1], values.at(kSh, i)[3 * 8 + 1]);
  }
}

/// A file of one primitive by its document and buffer.
std::string glb_of(const nlohmann::json& document, const std::string& buffer) {
  std::string text = document.dump(), file = "glTF";
  text.resize((text.size() + 3) / 4 * 4, ' ');
  append(file, uint32_t{2});
  append(file, uint32_t(28 + text.size() + buffer.size()));
  append(file, uint32_t(text.size()));
  file += "JSON" + text;
  append(file, uint32_t(buffer.size()));
  return file + std::string("BIN\0", 4) + buffer;
}

// Two splats whose attributes are normalised integers with a stride. Bugs put back, each seen to
// fail: the stride not looked at; negative scales as linear ones.
TEST(SplatFiles, GlbOfOthersIsRead) {
  const ScratchFolder folder;
  std::string buffer;
  for (const float x : {1.f, 2.f, 3.f, 4.f, 5.f, 6.f, 0.5f, 0.25f, 0.125f, 1.f, 1.f, 1.f})
    append(buffer, x);
  for (const int16_t x : {0, 0, 0, 32767, 32767, 0, 0, 0}) append(buffer, x);
  for (const uint8_t x : {128, 9, 9, 9, 255, 9, 9, 9}) append(buffer, x);  // opacity, every fourth
  for (const float x : {.1f, .2f, .3f, .4f, .5f, .6f}) append(buffer, x);
  const std::string name = "KHR_gaussian_splatting:";
  const auto accessor = [](int view, int type, const char* kind) {
    return nlohmann::json{
        {"bufferView", view}, {"componentType", type}, {"count", 2}, {"type", kind}};
  };
  nlohmann::json document = {
      {"asset", {{"version", "2.0"}}},
      {"nodes", {{{"mesh", 0}, {"scale", {2, 2, 2}}}}},
      {"meshes",
       {{{"primitives",
          {{{"attributes",
             {{"POSITION", 0},
              {name + "SCALE", 1},
              {name + "ROTATION", 2},
              {name + "OPACITY", 3},
              {name + "SH_DEGREE_0_COEF_0", 4}}},
            {"extensions", {{"KHR_gaussian_splatting", nlohmann::json::object()}}}}}}}}},
      {"accessors",
       {accessor(0, 5126, "VEC3"), accessor(1, 5126, "VEC3"), accessor(2, 5122, "VEC4"),
        accessor(3, 5121, "SCALAR"), accessor(4, 5126, "VEC3")}},
      {"bufferViews",
       {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 24}},
        {{"buffer", 0}, {"byteOffset", 24}, {"byteLength", 24}},
        {{"buffer", 0}, {"byteOffset", 48}, {"byteLength", 16}},
        {{"buffer", 0}, {"byteOffset", 64}, {"byteLength", 8}, {"byteStride", 4}},
        {{"buffer", 0}, {"byteOffset", 72}, {"byteLength", 24}}}},
      {"buffers", {{{"byteLength", buffer.size()}}}}};
  write_text_file(folder / "a.glb", glb_of(document, buffer));
  const SplatFile read = load_splat_file(folder / "a.glb");
  ASSERT_EQ(read.set.count(), 2);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("transforms of its nodes"), std::string::npos);
  const GaussianSpans<const float> values = read.set.values();
  EXPECT_EQ(values.at(kMean, 1)[0], -4);
  EXPECT_EQ(values.at(kMean, 1)[2], 6);
  EXPECT_FLOAT_EQ(values.at(kLogScale, 0)[1], std::log(0.25f));
  EXPECT_NEAR(sigmoid(*values.at(kOpacityLogit, 0)), 128 / 255.0, 1e-6);
  EXPECT_NEAR(sigmoid(*values.at(kOpacityLogit, 1)), 1, 2e-6);
  EXPECT_FLOAT_EQ(values.at(kSh, 1)[2], 0.6f);
  std::string draft = buffer;
  const float below = -1;
  std::memcpy(draft.data() + 24, &below, 4);
  write_text_file(folder / "a.glb", glb_of(document, draft));
  EXPECT_FLOAT_EQ(load_splat_file(folder / "a.glb").set.values().at(kLogScale, 0)[0], -1);
  const auto expect_refused = [&](const std::function<void(nlohmann::json&)>& change,
                                  const char* part) {
    nlohmann::json changed = document;
    change(changed);
    write_text_file(folder / "b.glb", glb_of(changed, buffer));
    expect_input_error([&] { load_splat_file(folder / "b.glb"); }, {"b.glb", part});
  };
  auto primitive = [](nlohmann::json& d) -> nlohmann::json& {
    return d["meshes"][0]["primitives"][0];
  };
  expect_refused([&](auto& d) { primitive(d)["attributes"].erase(name + "OPACITY"); }, "OPACITY");
  expect_refused([&](auto& d) { primitive(d).erase("extensions"); }, "no primitive");
  expect_refused(
      [&](auto& d) {
        primitive(d)["extensions"]["KHR_gaussian_splatting"]["extensions"]["spz_2"] = 1;
      },
      "spz_2");
  expect_refused([](auto& d) { d["accessors"][1]["count"] = 3; }, "VEC3");
  expect_refused([](auto& d) { d["bufferViews"][4]["byteOffset"] = 73; }, "beyond");
  expect_refused([](auto& d) { d["accessors"][2]["componentType"] = 5125; }, "accessor");
}

// Bytes as nianticlabs/spz documents them. Bugs put back, each seen to fail: w first in the
// quaternion; the header's fractional bits ignored.
TEST(SplatFiles, SpzOfVersionTwoByItsBytes) {
  const unsigned char bytes[] = {
      'N', 'G', 'S', 'P',  2,    0,    0,    0, 1, 0, 0, 0,  // magic, version, splats
      0,   8,   0,   0,                                      // SH degree, fractional bits, flags, 0
      0,   1,   0,   0x00, 0xFE, 0xFF, 0x80, 0, 0,           // position 1, −2, ½ in 1/256
      255, 255, 0,   0,                                      // opacity; colour
      160, 176, 144,                                         // log scales 0, 1, −1
      204, 51,  128};  // x 0.6, y −0.6, z 0.004 of the rotation
  const ScratchFolder folder;
  write_text_file(folder / "2.spz", gzip({reinterpret_cast<const char*>(bytes), std::size(bytes)}));
  const GaussianSet set = load_splat_file(folder / "2.spz").set;
  ASSERT_EQ(set.count(), 1);
  const auto values = set.values();
  // right-up-back to right-down-front: y and z change their signs
  const double mean[] = {1, 2, -0.5}, log_scale[] = {0, 1, -1};
  const double z = 128 / 127.5 - 1, rotation[] = {std::sqrt(1 - 0.72 - z * z), 0.6, 0.6, -z};
  for (int k = 0; k < 3; ++k) {
    EXPECT_FLOAT_EQ(values.at(kMean, 0)[k], float(mean[k])) << k;
    EXPECT_FLOAT_EQ(values.at(kLogScale, 0)[k], float(log_scale[k])) << k;
  }
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(values.at(kRotation, 0)[k], rotation[k], 1e-6) << k;
}

// Bug put back: spz_format(4) with the writer of version 3; seen to fail.
TEST(SplatFiles, SpzIsOfTheVersionAskedFor) {
  const ScratchFolder folder;
  save_splat_file(spz_format(3), folder / "3.spz", set_to_write(3), {1});
  EXPECT_TRUE(is_gzip(read_text_file(folder / "3.spz")));
#ifdef TESSERA_HAS_ZSTD
  save_splat_file(spz_format(4), folder / "4.spz", set_to_write(3), {1});
  const std::string file = read_text_file(folder / "4.spz");
  EXPECT_EQ(file.substr(0, 5), "NGSP\4");
  EXPECT_EQ(file[15], 6) << "streams";
#endif
  expect_input_error([] { spz_format(5); }, {"--spz-version is 5", "3 and 4"});
}

/// Every beginning of a file, long ones in steps.
void expect_beginnings_refused(const std::filesystem::path& path, const std::string& whole) {
  for (size_t size = 0; size < whole.size(); size += size < 200 ? 1 : 37) {
    if (path.extension() == ".splat" && size % 32 == 0 && size > 0) continue;
    std::filesystem::remove(path);  // many: no file system waits for the disk with a new one
    std::ofstream(path, std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW(load_splat_file(path), InputError) << path << " of " << size << " bytes";
  }
}

// Bug put back: the length of .spz's columns ignored; seen to fail.
TEST(SplatFiles, CutOffAnywhereAreRefused) {
  const ScratchFolder folder;
  const GaussianSet set = set_to_write(3);
  for (const SplatFormat& format : read_formats()) {
    const std::filesystem::path path = folder / (std::string("a") + format.extension);
    save_splat_file(format, path, set, {1});
    const std::string whole = read_text_file(path);
    expect_beginnings_refused(path, whole);
    if (is_gzip(whole)) expect_beginnings_refused(path, gunzip(whole, 1000000, path));
  }
  const std::string bytes(100000, 'x');
  EXPECT_EQ(gunzip(gzip(bytes), 100000, "a"), bytes);
  expect_input_error([&] { gunzip(gzip(bytes), 99999, "a.spz"); }, {"a.spz", "holds more"});
}

// Other people's: one file of four round splats in three formats (the .splat has its quaternions in
// another order than all that read it); and version 2, of an older writer with
// another world, with and without gzip.
TEST(SplatFiles, OfOtherWritersAgree) {
  TESSERA_NEED_DATA(folder, "splats/small");
  const SplatFile rows = load_splat_file(folder / "minimal.splat");
  ASSERT_EQ(rows.set.count(), 4);
  for (const char* name : {"minimal-v3.spz", "minimal-v4.spz"}) {
    SCOPED_TRACE(name);
    const SplatFile other = load_splat_file(folder / name);
    EXPECT_EQ(other.set.values().at(kMean, 0)[2], -1) << "right-up-back";
    EXPECT_EQ(other.set.values().at(kRotation, 0)[0], 1);
    constexpr double kAny = 2;
    expect_within(rows.set, other.set, {1e-3, 0.04, 0.01, 0.02, 0.01, kAny});
  }
  const SplatFile two = load_splat_file(folder / "minimal-v2.spz");
  EXPECT_TRUE(same_bits(two.set, load_splat_file(folder / "minimal-raw.spz").set));
  EXPECT_EQ(two.set.values().at(kMean, 0)[0], -1);
  EXPECT_NEAR(two.set.values().at(kRotation, 0)[0], 1, 1e-4);
}

// Bug put back: .splat rows of 36 bytes; seen to fail.
TEST(SplatFiles, OfOtherWritersAreAllRead) {
  TESSERA_NEED_DATA(folder, "splats");
  const std::map<std::string, int64_t> counts = {
      {"biker.compressed.ply", 152746},
      {"biker.spz", 152746},
      {"fruit_drops_minimal.ply", 4721},
      {"sample.splat", 89945},
      {"test.ply", 64},
      {"small/minimal.splat", 4},
      {"small/minimal-raw.spz", 4},
      {"small/minimal-v2.spz", 4},
      {"small/minimal-v3.spz", 4},
      {"small/minimal-v4.spz", 4},
  };
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".ksplat") continue;
    const std::string name = std::filesystem::relative(entry.path(), folder);
    SCOPED_TRACE(name);
    ASSERT_TRUE(counts.contains(name));
    const SplatFile read = load_splat_file(entry.path());
    EXPECT_EQ(read.set.count(), counts.at(name));
    EXPECT_EQ(valid_elements(read.set).size(), size_t(read.set.count()));
  }
  expect_input_error([&] { load_splat_file(folder / "small/minimal.ksplat"); },
                     {"minimal.ksplat", "splat-transform"});
}

/// A colour over all, so that an image is not only background.
TEST(SplatFiles, ASplatFileOfOthersIsSeen) {
  TESSERA_NEED_DATA(path, "splats/sample.splat");
  SplatFile read = load_splat_file(path);
  EXPECT_TRUE(read.warnings.empty());
  GaussianModel model = random_model(0, 0);
  model.static_set = std::move(read.set);
  model.drawing.sh_degree = 0;
  EXPECT_GT(coverage(render_one(model, three_views()[0])), 0.05);
}

}  // namespace
}  // namespace tessera::testing
