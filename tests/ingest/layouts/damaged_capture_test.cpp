// Every file of small photo captures damaged in every way, one at a time.
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "ingest/files/png.h"
#include "ingest/ingest.h"
#include "ingest/poses/llff_poses.h"
#include "tests/ingest/colmap/colmap_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using std::filesystem::path;

struct Damage {
  const char* name;
  std::function<void(const path&)> apply;
};

std::vector<Damage> damages() {
  std::vector<Damage> all{
      {"zero bytes", [](const path& file) { write_bytes(file, ""); }},
      {"truncated",
       [](const path& file) {
         const std::string bytes = read_bytes(file);
         write_bytes(file, bytes.substr(0, bytes.size() / 2));
       }},
      {"corrupt",
       [](const path& file) {
         std::string bytes = read_bytes(file);
         for (size_t i = bytes.size() / 3; i < bytes.size(); i += 2)
           bytes[i] = char(bytes[i] ^ 0x5a);
         write_bytes(file, bytes);
       }},
      {"of another kind", [](const path& file) { write_bytes(file, "%PDF-1.4\n%%EOF\n"); }},
      {"a link loop",
       [](const path& file) {
         std::filesystem::remove(file);
         std::filesystem::create_symlink(file, file);
       }},
      {"a folder", [](const path& file) {
         std::filesystem::remove(file);
         std::filesystem::create_directory(file);
       }}};
  if (::geteuid() != 0)  // root reads everything
    all.push_back({"unreadable", [](const path& file) { ::chmod(file.c_str(), 0); }});
  return all;
}

void write_llff(const path& capture) {
  WrittenModel model = small_colmap_model(4);
  write_photo_set(capture, model);
  std::filesystem::remove_all(capture / "sparse");
  std::vector<LlffPose> poses(4);
  for (int i = 0; i < 4; ++i) {
    poses[size_t(i)].camera = {32, 24, 40, 40, 16, 12, 0, glm::dmat3(1), glm::dvec3(i, 0, 0)};
    poses[size_t(i)].near = 1;
    poses[size_t(i)].far = 5;
  }
  write_llff_poses(capture / "poses_bounds.npy", poses);
}

/// One line that names the file, and no scene; or a scene, and a warning that names the file.
/// Under --strict always the first.
void expect_said(const path& capture, const path& file, const std::string& what, bool is_image) {
  const TemporaryFolder out;
  const std::string name = file.stem().string();
  const std::string where = capture.filename().string() + "/" + name + " " + what;
  for (const bool strict : {false, true}) {
    IngestOptions options;
    options.strict = strict;
    std::string error;
    IngestReport report;
    try {
      report = ingest_capture(capture, out / "scene", options, {});
    } catch (const InputError& refused) {
      error = refused.what();
    } catch (const std::exception& other) {
      ADD_FAILURE() << where << ": " << other.what();
      return;
    }
    EXPECT_EQ(error.find('\n'), std::string::npos) << where << ": " << error;
    if (strict || !is_image) {
      EXPECT_FALSE(error.empty()) << where << (strict ? ", strict" : "");
      EXPECT_TRUE(std::filesystem::is_empty(out.path())) << where;
    } else {
      EXPECT_EQ(error, "") << where;
      EXPECT_EQ(report.frames, 3) << where;
      EXPECT_TRUE(std::any_of(
          report.warnings.begin(), report.warnings.end(),
          [&](const std::string& line) { return line.find(name) != std::string::npos; }))
          << where;
      std::filesystem::remove_all(out / "scene");
    }
  }
}

/// Damages each file of a fresh capture, first, middle and last image included.
void damage_everything(const std::function<void(const path&)>& write,
                       const std::vector<std::string>& images,
                       const std::vector<std::string>& others) {
  for (const Damage& damage : damages())
    for (const bool is_image : {true, false})
      for (const std::string& name : is_image ? images : others) {
        const TemporaryFolder folder;
        write(folder / "capture");
        const path file = folder / "capture" / name;
        ASSERT_TRUE(std::filesystem::exists(file)) << name;
        damage.apply(file);
        expect_said(folder / "capture", file, damage.name, is_image);
        ::chmod(file.c_str(), 0600);
      }
}

// B16.
TEST(DamagedCapture, TransformsFiles) {
  damage_everything([](const path& folder) { write_dnerf(folder, {.test = 0}); },
                    {"train/r_000.png", "train/r_001.png", "train/r_003.png"},
                    {"transforms_train.json"});
}

TEST(DamagedCapture, ColmapPhotos) {
  damage_everything([](const path& folder) { write_photo_set(folder, small_colmap_model(4)); },
                    {"images/b00.png", "images/b02.png", "images/b03.png"},
                    {"sparse/0/cameras.bin", "sparse/0/images.bin"});
}

TEST(DamagedCapture, LlffPhotos) {
  // Bugs put back: is_regular_file() without an error code, which throws at a link loop; --strict
  // ignored; each seen to fail.
  for (const char* name : {"b00", "b03"})  // a missing image would shift the rows: an error
    for (const Damage& damage : damages()) {
      const bool is_gone =
          std::string(damage.name) == "a link loop" || std::string(damage.name) == "a folder";
      const TemporaryFolder folder;
      write_llff(folder / "capture");
      const path file = folder / fmt::format("capture/images/{}.png", name);
      damage.apply(file);
      if (is_gone)
        expect_input_error([&] { ingest_capture(folder / "capture", folder / "scene", {}, {}); },
                           {"has 4 rows", "has 3 images"});
      else
        expect_said(folder / "capture", file, damage.name, true);
    }
}

TEST(DamagedCapture, WithoutATrainingImageNothingIsLeft) {
  const TemporaryFolder folder;
  write_dnerf(folder / "capture", {});
  for (int i = 0; i < 4; ++i)
    write_bytes(folder / fmt::format("capture/train/r_00{}.png", i), "no image");
  expect_input_error([&] { ingest_capture(folder / "capture", folder / "scene", {}, {}); },
                     {"r_000.png", "no image of the split 'train' is left"});
  for (const char* name : {"train", "test"}) std::filesystem::remove_all(folder / "capture" / name);
  expect_input_error([&] { ingest_capture(folder / "capture", folder / "scene", {}, {}); },
                     {"no such image, nor any of the 5 others"});
  EXPECT_FALSE(std::filesystem::exists(folder / "scene"));
}

TEST(DamagedCapture, FramesKeepTheirNumbersWhereOthersAreMissing) {
  const TemporaryFolder folder;
  write_dnerf(folder / "capture", {});
  std::filesystem::remove(folder / "capture/train/r_001.png");
  std::filesystem::remove(folder / "capture/test/r_000.png");
  EXPECT_EQ(ingest_capture(folder / "capture", folder / "scene", {}, {}).frames, 4);
  const Scene scene = load_scene(folder / "scene", {});
  EXPECT_EQ(scene.frames[1].name, "train/r_002");
  EXPECT_EQ(scene.frames[1].frame_number, 2);
}

}  // namespace
}  // namespace tessera
