// Lines are compared with the name of their camera taken out, where it stands as a word.
#include "ingest/steps/alike_warnings.h"

#include <fmt/format.h>

#include <cctype>
#include <map>

#include "ingest/test_views.h"

namespace tessera {
namespace {

/// `line` with a placeholder for `name`; as it is where that is no word of it.
std::string without_name(const std::string& line, const std::string& name) {
  const auto is_letter = [&](size_t i) {
    return i < line.size() && (std::isalnum(static_cast<unsigned char>(line[i])) || line[i] == '_');
  };
  std::string text;
  size_t begin = 0;
  for (size_t i = line.find(name); i != std::string::npos; i = line.find(name, i + name.size())) {
    if (is_letter(i - 1) || is_letter(i + name.size())) continue;
    text += line.substr(begin, i - begin) + '\x01';
    begin = i + name.size();
  }
  return text + line.substr(begin);
}

}  // namespace

std::vector<std::string> merged_alike(const std::vector<std::string>& lines,
                                      const std::vector<std::string>& cameras) {
  constexpr size_t kMany = 3;
  std::map<std::string, std::vector<std::string>> named;  // cameras by the text without the name
  std::vector<std::string> texts;                         // of each line
  for (const std::string& line : lines) {
    std::string& text = texts.emplace_back();
    for (const std::string& camera : cameras) {
      if (camera.empty()) continue;
      const std::string without = without_name(line, camera);
      if (without == line) continue;
      text = without;
      named[text].push_back(camera);
      break;
    }
  }
  std::vector<std::string> merged;
  for (size_t i = 0; i < lines.size(); ++i) {
    const auto alike = named.find(texts[i]);
    if (alike == named.end() || alike->second.size() < kMany) {
      if (alike != named.end() || texts[i].empty()) merged.push_back(lines[i]);
      continue;
    }
    std::vector<std::string>& others = alike->second;
    others.erase(others.begin());
    merged.push_back(fmt::format("{} (likewise: {})", lines[i], listed_names(others)));
    named.erase(alike);  // the other lines are said
  }
  return merged;
}

}  // namespace tessera
