// What: the rules that the source tree keeps: who may include whom, how long files are, what each
//       begins with, and that only tools/ speaks to a terminal.
// Not: a compiler: lines are read as text. Source: the table of layers in ARCHITECTURE.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using Lines = std::vector<std::string>;

const fs::path kRoot = TESSERA_SOURCE_DIR;
constexpr size_t kAskAt = 400, kFailAt = 600;  // lines

/// What each folder may include of the tree, by prefix; the longest folder that fits decides.
const std::map<std::string, std::vector<std::string>> kMayInclude = {
    {"kernels/base/", {"kernels/base/"}},
    {"kernels/math/", {"kernels/base/", "kernels/math/", "kernels/gaussians.h"}},
    {"kernels/", {"kernels/"}},
    {"ingest/files/", {"kernels/base/", "ingest/files/", "ingest/scene.h"}},
    {"ingest/", {"kernels/", "ingest/"}},
    {"recon4d/", {"kernels/", "ingest/scene.h", "ingest/files/", "recon4d/"}},
    {"static3d/", {"kernels/", "ingest/scene.h", "ingest/files/", "recon4d/", "static3d/"}},
    {"tools/", {"kernels/", "ingest/", "recon4d/", "static3d/", "tools/"}},
    {"tests/", {""}},
};

/// Third-party headers that have one place.
const std::vector<std::pair<std::string, std::vector<std::string>>> kOnlyIn = {
    {"opencv2/", {"ingest/media/", "tests/"}},
    {"libav", {"ingest/media/", "tools/", "tests/"}},
    {"libsw", {"ingest/media/", "tools/", "tests/"}},
    {"OpenImageIO/", {"ingest/media/", "tests/"}},
    {"png.h", {"ingest/files/", "tests/"}},
    {"CLI/", {"tools/"}},
    {"spdlog/", {"tools/"}},
    {"iostream", {"tools/", "tests/"}},
    {"oneapi/", {"kernels/base/parallel_tbb.cpp"}},
    {"tbb/", {"kernels/base/parallel_tbb.cpp"}},
    {"cuda", {"kernels/"}},
    {"cub/", {"kernels/"}},
    {"thrust/", {"kernels/"}},
    {"nlohmann/", {"ingest/", "recon4d/", "static3d/", "tools/", "tests/"}},
    {"gtest/", {"tests/"}},
};

bool starts_with_any(const std::string& text, const std::vector<std::string>& prefixes) {
  for (const std::string& prefix : prefixes)
    if (text.starts_with(prefix)) return true;
  return false;
}

/// Why the file may not have this line; "" when it may or when it is no include.
std::string include_complaint(const std::string& file, const std::string& line) {
  static const std::regex kInclude(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
  std::smatch match;
  if (!std::regex_search(line, match, kInclude)) return "";
  const std::string header = match[2];
  if (match[1] == "<") {
    for (const auto& [prefix, places] : kOnlyIn)
      if (header.starts_with(prefix) && !starts_with_any(file, places))
        return file + " includes <" + header + ">, which has its place elsewhere";
    return "";
  }
  const std::vector<std::string>* allowed = nullptr;
  size_t longest = 0;
  for (const auto& [folder, prefixes] : kMayInclude)
    if (file.starts_with(folder) && folder.size() > longest)
      allowed = &prefixes, longest = folder.size();
  if (allowed == nullptr) return file + " belongs to no layer";
  if (!starts_with_any(header, *allowed)) return file + " may not include \"" + header + "\"";
  return "";
}

/// Why the first lines are not the header comment that each file has.
std::string heading_complaint(const std::string& file, const Lines& lines) {
  if (lines.empty() || !lines[0].starts_with("// What: "))
    return file + " does not begin with '// What: '";
  for (const std::string& line : lines) {
    if (!line.starts_with("//")) break;
    if (line.find("Not: ") != std::string::npos) return "";
  }
  return file + " does not say '// Not: ' in its first comment";
}

/// Why the line may not stand in a file outside tools/ and tests/.
std::string speech_complaint(const std::string& file, const std::string& line) {
  if (file.starts_with("tools/") || file.starts_with("tests/")) return "";
  static const std::regex kSpeech(
      R"re(\b(exit|_Exit|quick_exit|abort|printf|fprintf|puts|putchar|perror)\s*\(|\b(cout|cerr|clog)\b)re");
  const std::string code = line.substr(0, line.find("//"));
  return std::regex_search(code, kSpeech) ? file + " speaks or ends the program: " + line : "";
}

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
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string kind = entry.path().extension();
      if (kind == ".h" || kind == ".cpp" || kind == ".cu" || kind == ".cuh")
        files[fs::relative(entry.path(), kRoot)] = lines_of(entry.path());
    }
  return files;
}

// Each was seen to fail: recon4d/schedule.cpp with an include of tools/, an include of nothing,
// std::cout, 600 lines more, no first line; a .cu file in recon4d/; a header without its pragma.
class Layering : public ::testing::Test {
 protected:
  const std::map<std::string, Lines> sources_ = sources();
};

TEST_F(Layering, IncludesPointDown) {
  ASSERT_GT(sources_.size(), 100u) << "the tree was not found at " << kRoot;
  size_t includes = 0;
  for (const auto& [file, lines] : sources_)
    for (const std::string& line : lines) {
      EXPECT_EQ(include_complaint(file, line), "");
      includes += line.starts_with("#include \"");
    }
  EXPECT_GT(includes, 300u);
}

TEST_F(Layering, IncludedFilesAreNamedFromTheRoot) {
  static const std::regex kQuoted(R"re(^#include "([^"]+)")re");
  std::smatch match;
  for (const auto& [file, lines] : sources_)
    for (const std::string& line : lines)
      EXPECT_TRUE(!std::regex_search(line, match, kQuoted) || fs::exists(kRoot / match[1].str()) ||
                  fs::exists(kRoot / (match[1].str() + ".in")))
          << file << ": " << line;
}

TEST_F(Layering, CudaFilesAreKernels) {
  for (const auto& [file, lines] : sources_)
    EXPECT_TRUE(!fs::path(file).extension().string().starts_with(".cu") ||
                starts_with_any(file, {"kernels/", "tests/"}))
        << file;
}

TEST_F(Layering, FilesAreShort) {
  for (const auto& [file, lines] : sources_) {
    EXPECT_LE(lines.size(), kFailAt) << file;
    if (lines.size() > kAskAt)
      std::cerr << "ask: " << file << " has " << lines.size() << " lines\n";
  }
}

TEST_F(Layering, FilesSayWhatTheyAre) {
  for (const auto& [file, lines] : sources_) EXPECT_EQ(heading_complaint(file, lines), "");
}

TEST_F(Layering, HeadersAreIncludedOnce) {
  for (const auto& [file, lines] : sources_)
    EXPECT_EQ(file.ends_with(".h") || file.ends_with(".cuh"),
              std::find(lines.begin(), lines.end(), "#pragma once") != lines.end())
        << file;
}

TEST_F(Layering, OnlyToolsSpeak) {
  for (const auto& [file, lines] : sources_)
    for (const std::string& line : lines) EXPECT_EQ(speech_complaint(file, line), "");
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
      {"kernels/stages/a.cpp", "#include \"recon4d/trainer.h\""},
      {"kernels/stages/a.cpp", "#include \"ingest/scene.h\""},
      {"kernels/math/a.h", "#include \"kernels/stages/gradient_sink.h\""},
      {"kernels/math/a.h", "#include \"kernels/backend.h\""},
      {"kernels/base/a.h", "#include \"kernels/math/scalar.h\""},
      {"kernels/a.cpp", "#include <nlohmann/json.hpp>"},
      {"ingest/a.cpp", "#include \"recon4d/gaussian_set.h\""},
      {"recon4d/a.cpp", "#include \"ingest/scene_reader.h\""},
      {"recon4d/a.cpp", "#include \"static3d/lift.h\""},
      {"recon4d/a.cpp", "#include <cuda_runtime.h>"},
      {"recon4d/a.cpp", "#  include  \"tests/support/random.h\""},
      {"static3d/a.cpp", "#include \"tools/terminal.h\""},
      {"static3d/a.cpp", "#include \"ingest/media/conversion.h\""},
      {"tools/a.cpp", "#include \"tests/support/random.h\""},
      {"tools/a.cpp", "#include <opencv2/core.hpp>"},
      {"elsewhere/a.cpp", "#include \"kernels/batch.h\""},
      {"recon4d/a.cpp", "#include \"trainer.h\""}};
  for (const auto& [file, line] : wrong) EXPECT_NE(include_complaint(file, line), "") << line;
  EXPECT_EQ(include_complaint("recon4d/a.cpp", "#include \"ingest/scene.h\""), "");
  EXPECT_EQ(include_complaint("recon4d/a.cpp", "#include \"ingest/files/ply.h\""), "");
  EXPECT_EQ(include_complaint("recon4d/a.cpp", "// no #include \"tools/terminal.h\" here"), "");

  EXPECT_NE(heading_complaint("a.h", {}), "");
  EXPECT_NE(heading_complaint("a.h", {"#pragma once", "// What: a", "// Not: b"}), "");
  EXPECT_NE(heading_complaint("a.h", {"// What: a", "#pragma once", "// Not: b"}), "");
  EXPECT_EQ(heading_complaint("a.h", {"// What: a", "// Not: b"}), "");

  for (const char* line : {"  std::cout << x;", "printf(\"x\");", "if (bad) exit(1);",
                           "std::fprintf(stderr, \"x\");", "  abort ();", "using std::cerr;"})
    EXPECT_NE(speech_complaint("recon4d/a.cpp", line), "") << line;
  for (const char* line : {"// printf(...)", "std::snprintf(text, 9, \"x\");", "on_exit_(1);"})
    EXPECT_EQ(speech_complaint("recon4d/a.cpp", line), "") << line;
  EXPECT_EQ(speech_complaint("tools/a.cpp", "std::cout << x;"), "");
}

}  // namespace
}  // namespace tessera
