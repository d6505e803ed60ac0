// What: sources, and with them help and messages, use the field's words (tests/banned_words.h).
// Not: documents, nor keys of JSON files, which users have.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "tests/banned_words.h"
#include "tests/source_tree.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The line without strings that are a single word: keys of JSON files, options, names of files.
std::string without_keys(const std::string& line) {
  static const std::regex kKey(R"re("[^" ]*"|`[^`]*`|--[\w-]+)re");
  return std::regex_replace(line, kKey, "");
}

bool is_excepted(const BannedWord& word, const std::string& file) {
  for (const std::string& folder : word.except)
    if (file.starts_with(folder)) return true;
  return false;
}

/// "file: line: word → what to say"; empty where nothing is banned.
std::string complaint(const std::string& file, const std::string& line) {
  for (const BannedWord& word : kBannedWords) {
    const std::regex pattern(word.pattern, std::regex::icase);
    if (!is_excepted(word, file) && std::regex_search(without_keys(line), pattern))
      return file + ": " + line + "\n  say: " + word.instead;
  }
  return "";
}

// Seen to fail before each of them was replaced.
TEST(Words, AreTheFieldsOwn) {
  size_t lines = 0;
  for (const char* folder : {"kernels", "ingest", "recon4d", "static3d", "tools", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(kSourceRoot / folder)) {
      const std::string file = fs::relative(entry.path(), kSourceRoot);
      if (!is_source(entry.path()) || file == "tests/banned_words.h" ||
          file == "tests/words_test.cpp")
        continue;
      std::ifstream text(entry.path());
      for (std::string line; std::getline(text, line); ++lines)
        EXPECT_EQ(complaint(file, line), "");
    }
  EXPECT_GT(lines, 50000u);
}

TEST(Words, KeysAndAdamsMomentsStay) {
  EXPECT_EQ(complaint("tools/a.cpp", "json[\"moments\"] = 1;"), "");
  EXPECT_EQ(complaint("kernels/a.h", "// the moments of Adam"), "");
  EXPECT_NE(complaint("tools/a.cpp", "// the moments of a clip"), "");
  EXPECT_NE(complaint("tools/a.cpp", "say(\"the pictures are small\");"), "");
}

}  // namespace
}  // namespace tessera
