// Tests of .sog: values are read back, meta.json is that of the specification, and broken archives
// are refused.
// Source: formats 1.6, failure modes E2, E6.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/files/stored_zip.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/static3d/formats/splat_comparison.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

#ifdef TESSERA_HAS_WEBP
const SplatFormat& sog() {
  return splat_format("sog");
}

/// A copy of an archive with meta.json changed.
std::string with_meta(const std::string& archive,
                      const std::function<void(nlohmann::json&)>& change) {
  std::vector<ZipEntry> entries;
  for (const auto& [name, bytes] : zip_contents(archive, "a.sog")) {
    entries.push_back({name, std::string(bytes)});
    if (name != "meta.json") continue;
    nlohmann::json meta = nlohmann::json::parse(bytes);
    change(meta);
    entries.back().bytes = meta.dump();
  }
  return stored_zip(entries);
}

// 256 splats have a palette of 256, so that SH have the error of the codebook alone: 11,520 values
// within ±0.9. Means: range of ln(1 + |x|) about 3, times 1 + |x|.
// Bugs put back, each seen to fail: low and high bytes of means exchanged; the index of the largest
// part counted from x; red and blue of palette entries exchanged.
TEST(Sog, IsReadBackWithinItsQuanta) {
  const ScratchFolder folder;
  const GaussianSet set = set_to_write(256);
  for (const int degree : {0, 1, 2, 3}) {
    SCOPED_TRACE(degree);
    EXPECT_EQ(save_splat_file(sog(), folder / "a.sog", set, {degree}), 0);
    const SplatFile read = load_splat_file(folder / "a.sog");
    EXPECT_EQ(read.drawing.sh_degree, degree);
    EXPECT_TRUE(read.warnings.empty());
    expect_within(set, read.set, {2e-4, 0.02, 0.002, 0.02, 0.012, 0.0097});
  }
}

// Of at most 256 different values nothing is lost but the rounding of means and opacities, and each
// Gaussian is written once. Bug put back: the first Gaussian in the place of each other; seen to
// fail.
TEST(Sog, KeepsFewDifferentValuesAndEachGaussian) {
  const ScratchFolder folder;
  GaussianSet set = set_to_write(1000);
  const GaussianSpans<float> values = set.values();
  for (int64_t n = 0; n < 1000; ++n) {
    values.at(kMean, n)[0] = float(n) / 100;
    for (int k = 0; k < 3; ++k) values.at(kLogScale, n)[k] = -float((n + k) % 200) / 37;
    for (int i = 0; i < 48; ++i) values.at(kSh, n)[i] = float((n % 40 + i) % 50) / 60;
  }
  save_splat_file(sog(), folder / "a.sog", set, {3});
  const SplatFile read = load_splat_file(folder / "a.sog");
  expect_within(set, read.set, {4e-4, 0, 0.002, 0, 0, 0.0097});
  const std::vector<int64_t> rows = matched(set, read.set);
  EXPECT_EQ(std::set<int64_t>(rows.begin(), rows.end()).size(), 1000u);
}

// Bug put back: "bands" one too low; seen to fail.
TEST(Sog, HasMetaOfTheSpecification) {
  const ScratchFolder folder;
  save_splat_file(sog(), folder / "a.sog", set_to_write(300), {2});
  const std::string file = read_text_file(folder / "a.sog");
  const auto contents = zip_contents(file, "a.sog");
  const auto meta = nlohmann::json::parse(contents.at("meta.json"));
  EXPECT_EQ(meta["version"], 2);
  EXPECT_EQ(meta["count"], 300);
  EXPECT_EQ(meta["means"]["mins"].size(), 3u);
  EXPECT_LT(meta["means"]["mins"][0], meta["means"]["maxs"][0]);
  for (const char* key : {"scales", "sh0", "shN"})
    EXPECT_EQ(meta[key]["codebook"].size(), 256u) << key;
  EXPECT_EQ(meta["shN"]["count"], 256) << "the power of two below 300";
  EXPECT_EQ(meta["shN"]["bands"], 2);
  std::set<std::string> names{"meta.json"};
  for (const char* key : {"means", "scales", "quats", "sh0", "shN"})
    for (const auto& name : meta[key]["files"]) {
      names.insert(name);
      EXPECT_EQ(contents.at(name).substr(8, 8), "WEBPVP8L") << name;
    }
  EXPECT_EQ(names.size(), contents.size());
}

// Bug put back: the infinite range of no means; seen to fail.
TEST(Sog, OneSplatAndNone) {
  const ScratchFolder folder;
  const GaussianSet one = set_to_write(1);
  save_splat_file(sog(), folder / "a.sog", one, {3});
  expect_within(one, load_splat_file(folder / "a.sog").set, {1e-5, 0, 0.002, 0, 0, 0.0097});
  save_splat_file(sog(), folder / "a.sog", GaussianSet(SetForm::kStatic, 16), {3});
  EXPECT_EQ(load_splat_file(folder / "a.sog").set.count(), 0);
}

// Bug put back: all elements written; seen to fail.
TEST(Sog, LeavesOutWhatIsNotFinite) {
  const ScratchFolder folder;
  GaussianSet set = set_to_write(5);
  set.values().at(kMean, 1)[2] = std::numeric_limits<float>::quiet_NaN();
  set.values().at(kSh, 3)[40] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(save_splat_file(sog(), folder / "a.sog", set, {3}), 2);
  EXPECT_EQ(load_splat_file(folder / "a.sog").set.count(), 3);
}

// Bugs put back, each seen to fail: labels not compared with the palette; version not looked at.
TEST(Sog, BrokenFilesAreRefused) {
  const ScratchFolder folder;
  save_splat_file(sog(), folder / "a.sog", set_to_write(40), {1});
  const std::string good = read_text_file(folder / "a.sog");
  using Change = std::function<void(nlohmann::json&)>;
  const std::vector<std::pair<Change, std::vector<std::string>>> cases = {
      {[](auto& m) { m["version"] = 1; }, {"version 2"}},
      {[](auto& m) { m["count"] = 4000; }, {"pixels"}},
      {[](auto& m) { m["count"] = -1; }, {"count"}},
      {[](auto& m) {
         m["means"]["mins"] = {0, 1};
       },
       {"means"}},
      {[](auto& m) { m["scales"]["codebook"] = {1}; }, {"codebook"}},
      {[](auto& m) { m["quats"]["files"] = {"none.webp"}; }, {"none.webp"}},
      {[](auto& m) { m["sh0"] = 3; }, {"sh0"}},
      {[](auto& m) { m["shN"]["bands"] = 3; }, {"palette"}},
      {[](auto& m) { m["shN"]["count"] = 3; }, {"label"}},
  };
  for (size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(i);
    write_text_file(folder / "b.sog", with_meta(good, cases[i].first));
    std::vector<std::string> words = cases[i].second;
    words.emplace_back("b.sog");
    expect_input_error([&] { load_splat_file(folder / "b.sog"); }, words);
  }
}
#else
TEST(Sog, ABuildWithoutLibwebpNamesIt) {
  const ScratchFolder folder;
  expect_input_error(
      [&] { save_splat_file(splat_format("sog"), folder / "a.sog", set_to_write(2), {0}); },
      {"a.sog", "libwebp-dev"});
}
#endif

// Bugs put back, each seen to fail: the checksum not compared; the method not looked at.
TEST(StoredZip, IsReadBackAndBrokenOnesAreRefused) {
  const std::string archive = stored_zip({{"a", "first"}, {"b/c", ""}, {"d", "third"}});
  const auto contents = zip_contents(archive, "x.zip");
  ASSERT_EQ(contents.size(), 3u);
  EXPECT_EQ(contents.at("a"), "first");
  EXPECT_EQ(contents.at("b/c"), "");
  EXPECT_EQ(contents.at("d"), "third");
  EXPECT_EQ(zip_contents(archive + "a comment", "x.zip").size(), 3u);
  std::string changed = archive;
  changed[changed.find("third")] = 'T';
  expect_input_error([&] { zip_contents(changed, "x.zip"); }, {"x.zip", "checksum"});
  std::string deflated = archive;
  deflated[deflated.find("PK\1\2") + 10] = 8;
  expect_input_error([&] { zip_contents(deflated, "x.zip"); }, {"'a'", "compressed", "zip -0"});
  for (size_t size = 0; size < archive.size(); ++size)
    EXPECT_THROW(zip_contents(archive.substr(0, size), "x.zip"), InputError) << size;
}

}  // namespace
}  // namespace tessera::testing
