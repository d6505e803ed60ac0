// Tessera 4D files that are cut, damaged, hostile or of a later version are refused with one line
// and exit code 2.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/gzip.h"
#include "static3d/tessera4d/tessera4d.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/support/tessera4d_input.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

class SpoiltFile : public ::testing::Test {
 protected:
  SpoiltFile() : file_(encode_tessera4d(random_model(20, 30), {})) {}

  void write() { write_tessera4d_folder(folder_.path(), file_); }
  void edit(const std::function<void(json&)>& change) {
    json manifest = json::parse(file_.manifest);
    change(manifest);
    file_.manifest = manifest.dump();
    write();
  }
  void refused(const std::vector<std::string>& words) {
    expect_input_error([&] { load_tessera4d(folder_.path()); }, words);
  }
  void single_refused(const std::string& bytes, const std::vector<std::string>& words) {
    write_bytes(folder_ / "scene.t4d", bytes);
    expect_input_error([&] { load_tessera4d(folder_ / "scene.t4d"); }, words);
  }
  /// The stream of that name in block b.
  static json& stream(json& manifest, size_t b, const std::string& name) {
    for (json& stream : manifest["blocks"][b]["streams"])
      if (stream["name"] == name) return stream;
    throw std::logic_error("no stream " + name);
  }

  TemporaryFolder folder_;
  Tessera4dFile file_;
};

// Bugs put back: a version not compared, counts and offsets without a limit, names ignored;
// each seen to fail.
TEST_F(SpoiltFile, ManifestsThatCannotBe) {
  const std::vector<std::pair<std::function<void(json&)>, std::vector<std::string>>> cases = {
      {[](json& m) { m["version"] = 4; }, {"version 4", "newer"}},
      {[](json& m) { m["format"] = "gltf"; }, {"gltf", "tessera-4d"}},
      {[](json& m) { m.erase("blocks"); }, {"no 'blocks'"}},
      {[](json& m) { m["blocks"] = 3; }, {"'blocks'", "no list"}},
      {[](json& m) { m["time"]["duration"] = 0; }, {"duration"}},
      {[](json& m) { m["sh_degree"] = 4; }, {"sh_degree", "4"}},
      {[](json& m) { m["anchor"] = "dawn"; }, {"dawn"}},
      {[](json& m) {
         m["background"] = {1, 2};
       },
       {"background", "3 numbers"}},
      {[](json& m) { m["splat"]["far"] = 0; }, {"far_plane is 0"}},
      {[](json& m) { m["blocks"][0]["count"] = 1ull << 40; }, {"count", "1099511627776"}},
      {[](json& m) { m["blocks"][0]["count"] = -1; }, {"count", "-1"}},
      {[](json& m) { m["blocks"][0]["file"] = "../secret"; }, {"../secret", "plain name"}},
      {[](json& m) { m["blocks"][0]["file"] = ".."; }, {"'..'", "plain name"}},
      {[](json& m) { m["blocks"][0]["kind"] = "odd"; }, {"odd"}},
      {[](json& m) { m["blocks"][0]["bytes"] = 7; }, {"'bytes'"}},
      {[](json& m) { stream(m, 0, "colour")["offset"] = 1ull << 60; }, {"'offset'"}},
      {[](json& m) { stream(m, 0, "colour")["bytes"] = 1ull << 33; }, {"'bytes'"}},
      {[](json& m) { stream(m, 0, "colour")["count"] = 1000; }, {"'count'", "1000"}},
      {[](json& m) { stream(m, 0, "colour")["count"] = 3; }, {"more than its header says"}},
      {[](json& m) { stream(m, 0, "colour")["components"] = 2; }, {"'scale'"}},
      {[](json& m) { stream(m, 0, "colour")["codec"] = "zstd"; }, {"zstd", "cannot read"}},
      {[](json& m) { stream(m, 0, "colour")["type"] = "f16"; }, {"f16"}},
      {[](json& m) { stream(m, 0, "colour")["scale"][0] = nullptr; }, {"'scale'", "finite"}},
      {[](json& m) { stream(m, 0, "colour")["name"] = "opacity"; }, {"no stream 'colour'"}},
      {[](json& m) { stream(m, 1, "velocity")["name"] = "drift"; }, {"no stream 'velocity'"}},
  };
  const std::string sound = file_.manifest;
  for (size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(i);
    file_.manifest = sound;
    edit(cases[i].first);
    refused(cases[i].second);
  }
}

// Bug put back: unknown streams read as if known; seen to fail.
TEST_F(SpoiltFile, WhatNewerWritersAddIsSkipped) {
  edit([](json& m) {
    m["mood"] = "blue";
    json added = m["blocks"][0]["streams"][0];
    added["name"] = "glow";
    added["type"] = "f16";
    added["codec"] = "brotli";
    m["blocks"][0]["streams"].push_back(added);
  });
  EXPECT_EQ(load_tessera4d(folder_.path()).model.static_set.count(), file_.static_count);
}

// Bug put back: no checksum; seen to fail.
TEST_F(SpoiltFile, BlocksThatAreMissingCutOrChanged) {
  write();
  const std::string name = file_.blocks[1].first, bytes = file_.blocks[1].second;
  std::filesystem::remove(folder_ / name);
  refused({name});
  write_bytes(folder_ / name, bytes.substr(0, bytes.size() / 2));
  refused({name, "manifest says"});
  std::string changed = bytes;
  changed[changed.size() / 2] ^= 4;
  write_bytes(folder_ / name, changed);
  refused({name, "checksum"});
}

// Bytes that are wrong though checksum and manifest agree. Bug put back: lengths not compared; seen
// to fail.
TEST_F(SpoiltFile, StreamsThatAreNotWhatTheyPromise) {
  for (const auto& [content, word] : std::vector<std::pair<std::string, std::string>>{
           {"not gzip at all", "damaged"},
           {gzip(std::string(1 << 20, 'x')), "more than its header says"},
           {gzip("short"), "bytes, expected"}}) {
    SCOPED_TRACE(word);
    file_ = encode_tessera4d(random_model(20, 30), {});
    const uint64_t before = file_.blocks[0].second.size();
    file_.blocks[0].second += content;
    edit([&](json& m) {
      stream(m, 0, "position")["offset"] = before;
      stream(m, 0, "position")["bytes"] = content.size();
      m["blocks"][0]["bytes"] = file_.blocks[0].second.size();
      m["blocks"][0]["crc32"] = crc32_of(file_.blocks[0].second);
    });
    refused({word});
  }
}

// A block of equal Gaussians packs to a thousandth and is good; twenty of them, 500 MB in memory,
// are more than their 40 kB may hold, in a folder and in one file. Bugs put back: no such check;
// the blocks checked one at a time; each seen to fail.
TEST_F(SpoiltFile, NoMoreGaussiansThanItsBytesCanHold) {
  GaussianModel model = random_model(100000, 0);
  const GaussianSpans<float> to = model.static_set.values();
  for (int g = 0; g < model.static_set.groups(); ++g) {
    const int64_t width = model.static_set.width(Group(g));
    for (int64_t i = width; i < to.group[g].size; ++i)
      to.group[g].data[i] = to.group[g].data[i % width];
  }
  file_ = encode_tessera4d(model, {});
  ASSERT_EQ(file_.blocks.size(), 1u);
  write();
  EXPECT_EQ(load_tessera4d(folder_.path()).model.static_set.count(), 100000);
  const std::pair<std::string, std::string> block = file_.blocks[0];
  edit([&](json& m) {
    for (int i = 1; i < 20; ++i) {
      file_.blocks.emplace_back("again" + std::to_string(i) + ".bin", block.second);
      m["blocks"].push_back(m["blocks"][0]);
      m["blocks"][size_t(i)]["file"] = file_.blocks.back().first;
    }
  });
  refused({"promise", "Gaussians in", "damaged"});
  single_refused(single_tessera4d(file_), {"scene.t4d", "promise", "Gaussians in", "damaged"});
}

// Bug put back: blocks beyond the file read; seen to fail.
TEST_F(SpoiltFile, SingleFiles) {
  const std::string bytes = single_tessera4d(file_);
  single_refused(bytes.substr(0, 6), {"scene.t4d", "cut off"});
  single_refused(bytes.substr(0, 40), {"scene.t4d", "cut off"});
  single_refused(bytes.substr(0, bytes.size() - 5), {"scene.t4d", "cut off"});
  std::string future = bytes, broken = bytes;
  future[4] = 9;
  broken[20] = '}';
  single_refused(future, {"version 9"});
  single_refused(broken, {"scene.t4d", "not valid JSON"});
}

// Bug put back: rows that are not finite kept; seen to fail.
TEST_F(SpoiltFile, FloatsThatAreNotFiniteAreLeftOut) {
  Tessera4dOptions options;
  options.lossless = true;
  GaussianModel model = random_model(20, 0);
  file_ = encode_tessera4d(model, options);
  std::string planes;  // opacity_logit: four planes of 20
  edit([&](json& m) {
    json& logit = stream(m, 0, "opacity_logit");
    planes = gunzip(
        std::string_view(file_.blocks[0].second).substr(logit["offset"], logit["bytes"]), 80, "x");
    planes[40 + 3] = char(0xc0);
    planes[60 + 3] = char(0x7f);  // a NaN
    const std::string packed = gzip(planes);
    logit["offset"] = file_.blocks[0].second.size();
    logit["bytes"] = packed.size();
    file_.blocks[0].second += packed;
    m["blocks"][0]["bytes"] = file_.blocks[0].second.size();
    m["blocks"][0]["crc32"] = crc32_of(file_.blocks[0].second);
  });
  const Tessera4dInput read = load_tessera4d(folder_.path());
  EXPECT_EQ(read.model.static_set.count(), 19);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("1 Gaussians"), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing
