// Tests the rules of the source tree (layering_rules.h): includes between layers, lengths of files,
// head comments, output to a terminal only in tools/, and types defined once. Lines are read as
// text, without a compiler.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <set>

#include "tests/layering_rules.h"
#include "tests/source_tree.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr size_t kAskAt = 400, kFailAt = 600;  // lines

Lines lines_of(const fs::path& path) {
  std::ifstream file(path);
  Lines lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

/// Every C++ and CUDA file of the tree, by its path from the root.
std::map<std::string, Lines> sources() {
  std::map<std::string, Lines> files;
  for (const char* folder : {"kernels", "ingest", "recon4d", "static3d", "tools", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(kSourceRoot / folder)) {
      if (is_source(entry.path()))
        files[fs::relative(entry.path(), kSourceRoot)] = lines_of(entry.path());
    }
  return files;
}

// Bugs put back, each seen to fail: recon4d/training/schedule.cpp with an include of tools/, an
// include of nothing, std::cout, 600 lines more, no first line; a .cu file in recon4d/; a header
// without its pragma; stages/bin.cu with 600 lines more, cuda/tile_block.cuh without its first
// line.
class Layering : public ::testing::Test {
 protected:
  const std::map<std::string, Lines> sources_ = sources();
  const std::set<std::string> media_ = media_files(lines_of(kSourceRoot / "ingest/CMakeLists.txt"));
};

TEST_F(Layering, IncludesPointDown) {
  ASSERT_GT(sources_.size(), 100u) << "the tree was not found at " << kSourceRoot;
  size_t includes = 0;
  for (const auto& [file, lines] : sources_)
    for (const std::string& line : lines) {
      EXPECT_EQ(include_complaint(file, line, media_), "");
      includes += line.starts_with("#include \"");
    }
  EXPECT_GT(includes, 300u);
}

/// ingest/ has two targets in one tree of folders. An include of video/video_decoder.h in
/// checks/stations.cpp, and one of <opencv2/core.hpp>, were seen to fail IncludesPointDown.
TEST_F(Layering, IngestListsItsMediaFiles) {
  EXPECT_GT(media_.size(), 40u);
  for (const std::string& file : media_)
    EXPECT_TRUE(sources_.contains(file) ||
                sources_.contains(file.substr(0, file.rfind('.')) + ".cpp"))
        << file << " is listed but not there";
}

/// Bugs put back: kernels/math/splat.h with an include of kernels/gaussians.h; tools/session with
/// one of tools/export; each seen to fail.
TEST_F(Layering, FoldersHaveNoCircles) {
  FolderGraph graph;
  for (const auto& [file, lines] : sources_)
    if (!file.starts_with("tests/")) add_includes(file, lines, graph);
  EXPECT_GT(graph.size(), 30u);
  EXPECT_EQ(circle_of(graph), Lines());
}

TEST_F(Layering, FoldersAreSmall) {
  std::map<std::string, size_t> files;
  for (const auto& [file, lines] : sources_) ++files[folder_of(file)];
  for (const auto& [folder, count] : files) {
    EXPECT_LE(count, folder.starts_with("tests") ? 40u : 30u) << folder;
  }
}

TEST_F(Layering, IncludedFilesAreNamedFromTheRoot) {
  static const std::regex kQuoted(R"re(^#include "([^"]+)")re");
  std::smatch match;
  for (const auto& [file, lines] : sources_)
    for (const std::string& line : lines)
      EXPECT_TRUE(!std::regex_search(line, match, kQuoted) ||
                  fs::exists(kSourceRoot / match[1].str()) ||
                  fs::exists(kSourceRoot / (match[1].str() + ".in")))
          << file << ": " << line;
}

TEST_F(Layering, CudaFilesAreKernels) {
  for (const auto& [file, lines] : sources_)
    EXPECT_TRUE(!fs::path(file).extension().string().starts_with(".cu") ||
                starts_with_any(file, {"kernels/cuda/", "kernels/edits/", "kernels/measures/",
                                       "kernels/stages/"}))
        << file;
}

/// The tests below look at files of every kind.
TEST_F(Layering, EveryKindOfFileIsRead) {
  std::map<std::string, int> kinds;
  for (const auto& [file, lines] : sources_) ++kinds[fs::path(file).extension()];
  for (const char* kind : {".h", ".cpp", ".cu", ".cuh"}) EXPECT_GT(kinds[kind], 3) << kind;
}

TEST_F(Layering, FilesAreShort) {
  for (const auto& [file, lines] : sources_) {
    EXPECT_LE(lines.size(), kFailAt) << file;
    if (lines.size() > kAskAt)
      std::cerr << "ask: " << file << " has " << lines.size() << " lines\n";
  }
}

// Bug put back: a limit of 13,000 lines for kernels; seen to fail.
TEST_F(Layering, FoldersStayWithinTheirBudget) {
  std::map<std::string, size_t> counts;
  for (const auto& [file, lines] : sources_) counts[file.substr(0, file.find('/'))] += lines.size();
  for (const auto& [folder, count] : counts) {
    const auto most = kMostLines.find(folder);
    ASSERT_NE(most, kMostLines.end()) << folder;
    EXPECT_LE(count, most->second) << folder << ": cut something, or raise its budget for a reason";
  }
}

TEST_F(Layering, FilesBeginWithSentences) {
  for (const auto& [file, lines] : sources_) EXPECT_EQ(heading_complaint(file, lines), "");
}

TEST_F(Layering, HeadersAreIncludedOnce) {
  for (const auto& [file, lines] : sources_)
    EXPECT_EQ(file.ends_with(".h") || file.ends_with(".cuh"),
              std::find(lines.begin(), lines.end(), "#pragma once") != lines.end())
        << file;
}

TEST_F(Layering, OnlyToolsWriteToTheTerminal) {
  for (const auto& [file, lines] : sources_)
    for (const std::string& line : lines) EXPECT_EQ(speech_complaint(file, line), "");
}

/// One definition rule: two types of one name in one program are undefined behaviour, and the
/// linker does not report it. This test is fast; scripts/check_odr.sh checks the whole program by
/// the compiler. Bug put back: PlayerCamera named RigCamera, as the one of ingest/; seen to fail.
TEST_F(Layering, TypesAreDefinedOnce) {
  std::map<std::string, std::string> first;
  for (const auto& [file, lines] : sources_)
    for (const std::string& type : defined_types(lines)) {
      const auto [known, is_new] = first.emplace(type, file);
      EXPECT_TRUE(is_new) << type << " is defined in " << known->second << " and in " << file;
    }
  EXPECT_GT(first.size(), 400u);
}

TEST_F(Layering, NothingIsLeftToDo) {
  static const std::regex kLeft(
      "\\b(TO"
      "DO|FIX"
      "ME|XX"
      "X|HA"
      "CK)\\b");
  for (const auto& [file, lines] : sources_)
    for (const std::string& line : lines)
      EXPECT_FALSE(std::regex_search(line, kLeft)) << file << ": " << line;
}

/// The rules themselves: each of these must be refused.
TEST(LayeringRules, AreSeenToRefuse) {
  const std::pair<const char*, const char*> wrong[] = {
      {"kernels/stages/a.cpp", "#include \"recon4d/training/trainer.h\""},
      {"kernels/stages/a.cpp", "#include \"ingest/scene.h\""},
      {"kernels/math/a.h", "#include \"kernels/stages/gradient_sink.h\""},
      {"kernels/math/a.h", "#include \"kernels/backend.h\""},
      {"kernels/base/a.h", "#include \"kernels/math/scalar.h\""},
      {"kernels/a.cpp", "#include <nlohmann/json.hpp>"},
      {"ingest/a.cpp", "#include \"recon4d/model/gaussian_set.h\""},
      {"recon4d/a.cpp", "#include \"ingest/prepared/scene_reader.h\""},
      {"recon4d/a.cpp", "#include \"static3d/transform/slicer.h\""},
      {"recon4d/a.cpp", "#include <cuda_runtime.h>"},
      {"recon4d/a.cpp", "#include <cuda.h>"},
      {"recon4d/a.cpp", "#include \"kernels/cuda/device_memory.h\""},
      {"tools/a.cpp", "#include \"kernels/cuda/device_clock.h\""},
      {"kernels/backend.h", "#include <cuda_runtime.h>"},
      {"kernels/math/a.h", "#include <cuda_fp16.h>"},
      {"kernels/stages/a.h", "#include <cub/cub.cuh>"},
      {"kernels/stages/a.cpp", "#include \"kernels/cuda/sort.h\""},
      {"kernels/cpu_backend.cpp", "#include \"kernels/cuda/device_memory.h\""},
      {"kernels/cuda/a.cu", "#include <cuda.h>"},
      {"kernels/stages/a.cu", "#include \"recon4d/training/trainer.h\""},
      {"kernels/stages/a.cpp", "#include <nvtx3/nvToolsExt.h>"},
      {"recon4d/a.cpp", "#  include  \"tests/support/random.h\""},
      {"static3d/a.cpp", "#include \"tools/cli/terminal.h\""},
      {"static3d/a.cpp", "#include \"ingest/layouts/conversion.h\""},
      {"tools/a.cpp", "#include \"tests/support/random.h\""},
      {"tools/a.cpp", "#include <opencv2/core.hpp>"},
      {"elsewhere/a.cpp", "#include \"kernels/batch.h\""},
      {"kernels/math/a.h", "#include \"kernels/gaussians.h\""},
      {"recon4d/options/a.h", "#include \"recon4d/model/gaussian_set.h\""},
      {"tools/session/a.cpp", "#include \"tools/cli/terminal.h\""},
      {"tools/view/answer.cpp", "#include \"tools/cli/terminal.h\""},
      {"tools/view/answer.cpp", "#include <microhttpd.h>"},
      {"recon4d/a.cpp", "#include \"trainer.h\""}};
  for (const auto& [file, line] : wrong) EXPECT_NE(include_complaint(file, line), "") << line;
  EXPECT_EQ(include_complaint("recon4d/a.cpp", "#include \"ingest/scene.h\""), "");
  EXPECT_EQ(include_complaint("recon4d/a.cpp", "#include \"ingest/files/ply.h\""), "");
  EXPECT_EQ(include_complaint("recon4d/a.cpp", "// no #include \"tools/cli/terminal.h\" here"), "");
  for (const char* file : {"kernels/cuda/a.h", "kernels/stages/a.cu", "kernels/stages/a.cuh",
                           "kernels/edits/a.cu", "kernels/measures/a.cu"})
    for (const char* line : {"#include <cuda_runtime.h>", "#include <cub/device/device_scan.cuh>",
                             "#include \"kernels/cuda/sort.h\"", "#include \"kernels/batch.h\""})
      EXPECT_EQ(include_complaint(file, line), "") << line;

  const std::set<std::string> media =
      media_files({"tessera_library(NAME ingest", "  SOURCES", "    checks/a.cpp", "  PUBLIC b)",
                   "  tessera_library(NAME ingest_media", "    SOURCES", "      checks/m.cpp",
                   "      video/handles.h", "    PUBLIC b)", "set(cloud/c.cpp)"});
  EXPECT_EQ(media, (std::set<std::string>{"ingest/checks/m.cpp", "ingest/checks/m.h",
                                          "ingest/video/handles.h"}));
  for (const char* line : {"#include \"ingest/checks/m.h\"", "#include \"ingest/video/handles.h\"",
                           "#include <opencv2/core.hpp>", "#include <libavutil/frame.h>",
                           "#include <OpenImageIO/imageio.h>"}) {
    EXPECT_NE(include_complaint("ingest/checks/a.cpp", line, media), "") << line;
    EXPECT_NE(include_complaint("recon4d/a.cpp", line, media), "") << line;
    EXPECT_EQ(include_complaint("ingest/checks/m.cpp", line, media), "") << line;
  }
  EXPECT_EQ(include_complaint("tools/a.cpp", "#include \"ingest/checks/m.h\"", media), "");
  EXPECT_NE(include_complaint("ingest/checks/m.cpp", "#include \"kernels/batch.h\"", media), "");

  EXPECT_NE(heading_complaint("a.h", {}), "");
  EXPECT_NE(heading_complaint("a.h", {"#pragma once", "// Rays of a camera."}), "");
  EXPECT_EQ(heading_complaint("a.h", {"// Rays of a camera in", "// world space.", "code"}), "");
  EXPECT_NE(heading_complaint("a.h", {"// rays of a camera", "code"}), "");
  EXPECT_NE(heading_complaint("a.h", {"// Rays of a camera", "code"}), "");

  FolderGraph graph;
  add_includes("a/x.h", {"#include \"b/y.h\"", "#include <c/z.h>", "#include \"a/w.h\""}, graph);
  add_includes("b/y.h", {"#include \"c/z.h\""}, graph);
  EXPECT_EQ(circle_of(graph), Lines());
  add_includes("c/z.h", {"#include \"a/b/v.h\""}, graph);
  EXPECT_EQ(circle_of(graph), Lines());
  add_includes("a/b/v.h", {"#include \"a/x.h\""}, graph);
  EXPECT_EQ(circle_of(graph).size(), 4u);

  for (const char* line : {"  std::cout << x;", "printf(\"x\");", "if (bad) exit(1);",
                           "std::fprintf(stderr, \"x\");", "  abort ();", "using std::cerr;"})
    EXPECT_NE(speech_complaint("recon4d/a.cpp", line), "") << line;
  for (const char* line : {"// printf(...)", "std::snprintf(text, 9, \"x\");", "on_exit_(1);"})
    EXPECT_EQ(speech_complaint("recon4d/a.cpp", line), "") << line;
  EXPECT_EQ(speech_complaint("tools/a.cpp", "std::cout << x;"), "");
  EXPECT_NE(speech_complaint("tools/session/a.cpp", "std::cout << x;"), "");

  const Lines file = {"namespace a {",
                      "struct B;",
                      "struct C {",
                      "  struct D {",
                      "  };",
                      "};",
                      "namespace {",
                      "struct E {",
                      "};",
                      "}  // namespace",
                      "class F : C {",
                      "enum class G { kH };",
                      "template <>",
                      "struct I<int> {",
                      "}  // namespace a",
                      "struct J {};"};
  EXPECT_EQ(defined_types(file), (std::vector<std::string>{"a::C", "a::F", "a::G", "J"}));
}

}  // namespace
}  // namespace tessera
