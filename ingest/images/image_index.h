// Finds the image that another program names: its files may have other extensions and another case
// here, and its paths may be those of another computer.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace tessera {

/// The images below a folder by stated names.
class ImageIndex {
 public:
  explicit ImageIndex(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The image that `stated` names, `\` as `/`, by the first rule that holds: the very name; with
  /// the extension of an image behind it, .png first; with another extension; in another case or
  /// normal form of Unicode; the longest end of the path for which one of these holds. Empty where
  /// none does, and where a rule finds several. Errors: InputError: an end of two paths.
  std::filesystem::path find(const std::string& stated);

  /// A line for each rule beyond the first two that found images, with an example, and one for
  /// names that fit several files.
  std::vector<std::string> lines() const;

 private:
  enum class Rule { kStated, kExtension, kCase, kTail };
  struct Found {
    std::filesystem::path file;
    Rule rule = Rule::kStated;
  };
  struct Use {
    int64_t count = 0;
    std::string example;
  };

  Found find_below(const std::filesystem::path& stated);
  Found find_alike(const std::filesystem::path& stated);
  const std::vector<std::string>& listing(const std::filesystem::path& folder);
  void note(Use& use, const std::string& stated, const std::string& seen);

  const std::filesystem::path folder_;
  std::map<std::filesystem::path, std::vector<std::string>> listings_;  // names, sorted
  std::map<Rule, Use> uses_;
  Use several_;
  std::map<std::filesystem::path, std::string> by_tail_;  // what was stated of an image
};

}  // namespace tessera
