// Tests that sources (with their help and messages) and the documentation use the words of the
// field (tests/banned_words.h). Keys of JSON files, which users have, and research/, which keeps
// its original text, are exempt.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include "tests/banned_words.h"
#include "tests/source_tree.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The line without quoted single words: keys of JSON files, options, names of files.
std::string without_keys(const std::string& line) {
  static const std::regex kKey(R"re("[^" ]*"|'[^' ]*'|`[^`]*`|--[\w-]+)re");
  return std::regex_replace(line, kKey, "");
}

bool is_excepted(const BannedWord& word, const std::string& file) {
  for (const std::string& folder : word.except)
    if (file.starts_with(folder)) return true;
  return false;
}

/// The patterns of kBannedWords, in their order.
const std::vector<std::regex>& patterns() {
  static const std::vector<std::regex> kPatterns = [] {
    std::vector<std::regex> made;
    for (const BannedWord& word : kBannedWords) made.emplace_back(word.pattern, std::regex::icase);
    return made;
  }();
  return kPatterns;
}

/// The line and the words to use instead; empty where no word is banned. Code and comments alike.
std::string complaint(const std::string& file, const std::string& line) {
  const std::string visible = without_keys(line);
  for (size_t w = 0; w < kBannedWords.size(); ++w)
    if (!is_excepted(kBannedWords[w], file) && std::regex_search(visible, patterns()[w]))
      return file + ": " + line + "\n  instead: " + kBannedWords[w].instead;
  return "";
}

/// Expects no banned word in a file and returns the number of its lines.
size_t check_words(const fs::path& path) {
  const std::string file = fs::relative(path, kSourceRoot);
  std::ifstream text(path);
  size_t lines = 0;
  for (std::string line; std::getline(text, line); ++lines) EXPECT_EQ(complaint(file, line), "");
  return lines;
}

/// The same for the files of a folder that fit; folders of fetched packages are left out.
size_t check_folder(const char* folder, bool (*fits)(const fs::path&)) {
  size_t lines = 0;
  for (auto entry = fs::recursive_directory_iterator(kSourceRoot / folder);
       entry != fs::recursive_directory_iterator(); ++entry) {
    const std::string name = entry->path().filename();
    if (name == "node_modules" || name == "dist") entry.disable_recursion_pending();
    if (fits(entry->path()) && name != "banned_words.h" && name != "words_test.cpp")
      lines += check_words(entry->path());
  }
  return lines;
}

// Seen to fail before each of the words was replaced.
TEST(Words, OfSourcesAreTheFieldsOwn) {
  size_t lines = 0;
  for (const char* folder : {"kernels", "ingest", "recon4d", "static3d", "tools", "tests"})
    lines += check_folder(folder, is_source);
  EXPECT_GT(lines, 50000u);
}

// Seen to fail: README.md had "goes on", "moment" and "frontier", formulas.md "pictures".
TEST(Words, OfPagesAreTheFieldsOwn) {
  size_t lines = check_folder("docs", is_page);
  for (const char* page : {"README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"})
    lines += check_words(kSourceRoot / page);
  EXPECT_GT(lines, 2500u);
}

// Seen to fail: splat4d_shader.ts had a class Moment, stage.ts "the picture".
TEST(Words, OfThePlayerAreTheFieldsOwn) {
  EXPECT_GT(check_folder("tools/web", is_player_source), 1500u);
}

// Seen to fail with the head of scripts/check_mutations.py in its old form, "What: … Not: …".
TEST(Words, OfScriptsAreTheFieldsOwn) {
  EXPECT_GT(check_folder("scripts", is_script) + check_folder("tests", is_script), 5000u);
}

TEST(Words, HeadsOfTheOldFormAreRefused) {
  EXPECT_NE(complaint("kernels/a.h", "// What: rays. Not: lenses."), "");
  EXPECT_NE(complaint("kernels/a.h", "// Rays of a camera. Not: lenses."), "");
  EXPECT_NE(complaint("scripts/a.py", "\"\"\"What: rays of a camera."), "");
  EXPECT_EQ(complaint("kernels/a.h", "// Rays of a camera without a lens."), "");
}

TEST(Words, KeysAndAdamsMomentsStay) {
  EXPECT_EQ(complaint("tools/a.cpp", "json[\"moments\"] = 1;"), "");
  EXPECT_EQ(complaint("kernels/a.h", "// the moments of Adam"), "");
  EXPECT_NE(complaint("tools/a.cpp", "// the moments of a clip"), "");
  EXPECT_NE(complaint("tools/a.cpp", "say(\"the pictures are small\");"), "");
  EXPECT_NE(complaint("docs/a.md", "Training goes on."), "");
  EXPECT_EQ(complaint("tools/commands/a.h", "// Training goes on."), "");
}

}  // namespace
}  // namespace tessera
