// Looks at the file system for each name; a folder is listed once, where its names do not fit.
#include "ingest/images/image_index.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/images/image_paths.h"
#include "ingest/images/names.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// "img_00" of "img_00.JPG": without the extension of an image.
std::string stem_of(const std::string& name) {
  return is_image_name(name) ? fs::path(name).stem().string() : name;
}

/// From the root of some computer: "/home/…", "C:/Users/…".
bool is_rooted(const std::string& stated) {
  return stated.starts_with('/') || (stated.size() > 2 && stated[1] == ':' && stated[2] == '/');
}

}  // namespace

const std::vector<std::string>& ImageIndex::listing(const fs::path& folder) {
  const auto [known, is_new] = listings_.try_emplace(folder);
  if (!is_new) return known->second;
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(folder, unreachable))
    if (const std::string name = entry.path().filename().string(); !name.starts_with('.'))
      known->second.push_back(name);
  std::sort(known->second.begin(), known->second.end());
  return known->second;
}

/// By another extension, or by names that differ in form or case alone; no file where several fit.
ImageIndex::Found ImageIndex::find_alike(const fs::path& stated) {
  fs::path folder = folder_;
  Rule rule = Rule::kExtension;
  for (const fs::path& part : stated.parent_path()) {
    fs::path next = folder / part;
    if (!fs::is_directory(next)) {
      const std::vector<std::string>& names = listing(folder);
      const auto same = [&](const std::string& name) {
        return compared_name(name) == compared_name(part.string());
      };
      if (std::count_if(names.begin(), names.end(), same) != 1) return {};
      next = folder / *std::find_if(names.begin(), names.end(), same);
      rule = Rule::kCase;
    }
    folder = std::move(next);
  }
  const std::string stem = stem_of(stated.filename().string());
  std::vector<std::string> alike, same_case;
  for (const std::string& name : listing(folder)) {
    if (!is_image_name(name) || compared_name(stem_of(name)) != compared_name(stem)) continue;
    alike.push_back(name);
    if (stem_of(name) == stem) same_case.push_back(name);
  }
  if (same_case.empty()) rule = Rule::kCase;
  const std::vector<std::string>& fitting = same_case.empty() ? alike : same_case;
  if (fitting.size() == 1 && is_file(folder / fitting[0])) return {folder / fitting[0], rule};
  if (fitting.size() > 1)
    note(several_, stated.generic_string(), fmt::format("{} or {}", fitting[0], fitting[1]));
  return {};
}

ImageIndex::Found ImageIndex::find_below(const fs::path& stated) {
  if (const fs::path file = folder_ / stated; is_file(file)) return {file};
  if (fs::path file = with_image_extension(folder_ / stated); !file.empty()) return {file};
  return find_alike(stated);
}

void ImageIndex::note(Use& use, const std::string& stated, const std::string& seen) {
  if (use.count++ == 0) use.example = fmt::format("{}: {}", stated, seen);
}

fs::path ImageIndex::find(const std::string& stated) {
  std::string path = stated;
  std::replace(path.begin(), path.end(), '\\', '/');
  if (const fs::path whole = path; whole.is_absolute() && is_file(whole)) return whole;
  Found found;
  if (!is_rooted(path)) found = find_below(path);
  for (fs::path rest = fs::path(path).relative_path();
       found.file.empty() && rest.has_parent_path();) {
    fs::path shorter;
    for (auto part = std::next(rest.begin()); part != rest.end(); ++part) shorter /= *part;
    rest = std::move(shorter);
    found = find_below(rest);
    found.rule = Rule::kTail;
  }
  if (found.rule == Rule::kTail && !found.file.empty())
    if (const auto [first, is_new] = by_tail_.emplace(found.file, path);
        !is_new && first->second != path)
      throw InputError(fmt::format(
          "{}: {} and {} would both be {}; put the images into the folders that are stated",
          folder_.string(), first->second, path,
          found.file.lexically_relative(folder_).generic_string()));
  if (!found.file.empty() && found.rule != Rule::kStated)
    note(uses_[found.rule], stated, found.file.lexically_relative(folder_).generic_string());
  return found.file;
}

std::vector<std::string> ImageIndex::lines() const {
  std::vector<std::string> lines;
  const auto add = [&](const Use& use, const char* what) {
    lines.push_back(
        fmt::format("{}: {} images {} ({})", folder_.string(), use.count, what, use.example));
  };
  for (const auto& [rule, use] : uses_)
    add(use, rule == Rule::kExtension ? "are found with another extension than stated"
             : rule == Rule::kCase    ? "are found in another case than stated"
                                      : "are found in another folder than stated");
  if (several_.count > 0) add(several_, "are not taken, because several files fit");
  return lines;
}

}  // namespace tessera
