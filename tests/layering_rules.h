// The rules of the source tree, applied to lines of text: includes, head comments, output to a
// terminal, and defined types. Source: the table of layers in ARCHITECTURE.md.
#pragma once
#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace tessera {

using Lines = std::vector<std::string>;

/// What each layer may include of the tree, by prefix; the longest folder that fits decides.
/// Between the folders of one layer, and between a folder and its subfolders, includes must have no
/// cycle.
inline const std::map<std::string, std::vector<std::string>> kMayInclude = {
    {"kernels/base/", {"kernels/base/"}},
    {"kernels/math/", {"kernels/base/", "kernels/math/"}},
    {"kernels/", {"kernels/"}},
    {"ingest/files/", {"kernels/base/", "ingest/files/", "ingest/scene.h"}},
    // the target tessera_ingest_media, whose files stand beside those of tessera_ingest:
    // ruled_path()
    {"ingest_media/", {"kernels/base/", "ingest/", "ingest_media/"}},
    {"ingest/", {"kernels/", "ingest/"}},
    {"recon4d/options/", {"kernels/", "ingest/scene.h", "recon4d/options/"}},
    {"recon4d/", {"kernels/", "ingest/scene.h", "ingest/files/", "recon4d/"}},
    {"static3d/", {"kernels/", "ingest/scene.h", "ingest/files/", "recon4d/", "static3d/"}},
    // a library: the caller of a session prints
    {"tools/session/",
     {"kernels/", "ingest/", "ingest_media/", "recon4d/", "static3d/", "tools/session/"}},
    // the code that answers requests from outside depends on files alone
    {"tools/view/", {"kernels/base/", "tools/view/"}},
    // reports are made from files and images, by commands and by batches
    {"tools/report/",
     {"kernels/", "ingest/", "recon4d/", "tools/camera_paths/", "tools/clip/", "tools/web/",
      "tools/session/", "tools/report/", "tools/video/"}},
    {"tools/", {"kernels/", "ingest/", "ingest_media/", "recon4d/", "static3d/", "tools/"}},
    {"tests/", {""}},
};

/// Lines of C++ and CUDA that each top folder may have. A feature names what it replaces, or raises
/// the number in the commit that brings it; a cut lowers it.
inline const std::map<std::string, size_t> kMostLines = {{"kernels", 13693}, {"ingest", 26953},
                                                         {"recon4d", 12726}, {"static3d", 8174},
                                                         {"tools", 24894},   {"tests", 59018}};

/// Where CUDA may be used; host_device.h has the qualifiers.
inline const std::vector<std::string> kDevice = {"kernels/cuda/", "kernels/stages/*.cu",
                                                 "kernels/stages/*.cuh", "kernels/edits/*.cu",
                                                 "kernels/measures/*.cu"};
inline const std::vector<std::string> kDeviceAndItsTests = {
    "kernels/cuda/",      "kernels/stages/*.cu",   "kernels/stages/*.cuh",
    "kernels/edits/*.cu", "kernels/measures/*.cu", "tests/kernels/"};

/// Headers that have one place: by the beginning of their name.
inline const std::vector<std::pair<std::string, std::vector<std::string>>> kOnlyIn = {
    {"opencv2/", {"ingest_media/", "tools/lpips/", "tests/"}},
    {"libav", {"ingest_media/", "tools/", "tests/"}},
    {"libsw", {"ingest_media/", "tools/", "tests/"}},
    {"OpenImageIO/", {"ingest_media/", "tests/"}},
    {"png.h", {"ingest/files/", "tests/"}},
    {"libdeflate.h", {"ingest/files/", "tests/"}},
    {"CLI/", {"tools/"}},
    {"microhttpd.h", {"tools/view/view_server.cpp"}},
    {"spdlog/", {"tools/"}},
    {"iostream", {"tools/", "tests/"}},
    {"oneapi/", {"kernels/base/parallel_tbb.cpp"}},
    {"tbb/", {"kernels/base/parallel_tbb.cpp"}},
    {"cuda.h", {"kernels/base/host_device.h"}},
    {"cuda", kDevice},
    {"cooperative_groups", kDevice},
    {"cub/", kDevice},
    {"thrust/", kDevice},
    {"nvtx", kDevice},
    {"nvToolsExt", kDevice},
    {"kernels/cuda/", kDeviceAndItsTests},
    {"nlohmann/", {"ingest/", "ingest_media/", "recon4d/", "static3d/", "tools/", "tests/"}},
    {"gtest/", {"tests/"}},
};

inline bool starts_with_any(const std::string& text, const std::vector<std::string>& prefixes) {
  for (const std::string& prefix : prefixes)
    if (text.starts_with(prefix)) return true;
  return false;
}

/// Whether the file lies in one of the places: a prefix of its path, or prefix*suffix.
inline bool lies_in(const std::string& file, const std::vector<std::string>& places) {
  for (const std::string& place : places) {
    const size_t star = place.find('*');
    if (file.starts_with(place.substr(0, star)) &&
        (star == std::string::npos || file.ends_with(place.substr(star + 1))))
      return true;
  }
  return false;
}

/// The files of the target tessera_ingest_media and of its module by ingest/CMakeLists.txt: what
/// their lists of sources name, and the header of each source.
inline std::set<std::string> media_files(const Lines& cmake_lists) {
  static const std::regex kTarget(R"(NAME (\w+))"), kFile(R"(([\w/]+)\.(cpp|h)\b)");
  std::set<std::string> files;
  bool is_media = false;
  std::smatch match;
  for (const std::string& line : cmake_lists) {
    if (std::regex_search(line, match, kTarget))
      is_media = match[1] == "ingest_media" || match[1] == "openimageio";
    if (line.find("PUBLIC") != std::string::npos) is_media = false;  // the sources end there
    if (!is_media || !std::regex_search(line, match, kFile)) continue;
    files.insert("ingest/" + match[1].str() + "." + match[2].str());
    files.insert("ingest/" + match[1].str() + ".h");
  }
  return files;
}

/// The path by which the tables above name a file: "ingest_media/…" for one of `media`.
inline std::string ruled_path(const std::string& path, const std::set<std::string>& media) {
  return media.contains(path) ? "ingest_media/" + path.substr(path.find('/') + 1) : path;
}

/// Why the file may not have this line; "" when it may or when it is no include. `media`: see
/// media_files.
inline std::string include_complaint(const std::string& path, const std::string& line,
                                     const std::set<std::string>& media = {}) {
  static const std::regex kInclude(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
  std::smatch match;
  if (!std::regex_search(line, match, kInclude)) return "";
  const std::string file = ruled_path(path, media), header = ruled_path(match[2], media);
  for (const auto& [prefix, places] : kOnlyIn) {
    if (!header.starts_with(prefix)) continue;
    if (!lies_in(file, places))
      return file + " includes " + header + ", which has its place elsewhere";
    break;  // the first that fits decides
  }
  if (match[1] == "<") return "";
  const std::vector<std::string>* allowed = nullptr;
  size_t longest = 0;
  for (const auto& [folder, prefixes] : kMayInclude)
    if (file.starts_with(folder) && folder.size() > longest) {
      allowed = &prefixes;
      longest = folder.size();
    }
  if (allowed == nullptr) return file + " belongs to no layer";
  if (!starts_with_any(header, *allowed)) return file + " may not include \"" + header + "\"";
  return "";
}

/// By folder, the folders that its own files include, with one such include: "file includes
/// header".
using FolderGraph = std::map<std::string, std::map<std::string, std::string>>;

inline std::string folder_of(const std::string& path) {
  return path.substr(0, path.rfind('/') == std::string::npos ? 0 : path.rfind('/'));
}

/// Adds what the file includes of the tree, outside of its own folder.
inline void add_includes(const std::string& file, const Lines& lines, FolderGraph& graph) {
  static const std::regex kQuoted(R"re(^#include "([^"]+)")re");
  std::smatch match;
  for (const std::string& line : lines)
    if (std::regex_search(line, match, kQuoted)) {
      const std::string header = match[1];
      if (folder_of(header) != folder_of(file))
        graph[folder_of(file)].emplace(folder_of(header), file + " includes " + header);
    }
}

/// The includes that lead from `from` to `to`; empty where there is no way. `seen`: folders that
/// lead nowhere.
inline Lines way_between(const FolderGraph& graph, const std::string& from, const std::string& to,
                         std::set<std::string>& seen) {
  if (!graph.contains(from) || !seen.insert(from).second) return {};
  for (const auto& [folder, include] : graph.at(from)) {
    if (folder == to) return {include};
    Lines rest = way_between(graph, folder, to, seen);
    if (rest.empty()) continue;
    rest.insert(rest.begin(), include);
    return rest;
  }
  return {};
}

/// One circle of folders as its includes; empty where there is none.
inline Lines circle_of(const FolderGraph& graph) {
  for (const auto& [folder, included] : graph) {
    std::set<std::string> seen;
    if (Lines way = way_between(graph, folder, folder, seen); !way.empty()) return way;
  }
  return {};
}

/// Why the first lines are not the header comment that each file has.
inline std::string heading_complaint(const std::string& file, const Lines& lines) {
  std::string heading;
  for (const std::string& line : lines) {
    if (!line.starts_with("// ")) break;
    heading += line.substr(2);
  }
  if (heading.empty()) return file + " does not begin with a comment";
  const char first = heading.size() > 1 ? heading[1] : ' ';
  const bool is_sentence = first >= 'A' && first <= 'Z' && heading.ends_with('.');
  if (!is_sentence && first != '`') return file + " does not begin with full sentences";
  return "";
}

/// Why the line may not stand in a file outside tools/ and tests/, or in the library of sessions.
inline std::string speech_complaint(const std::string& file, const std::string& line) {
  const bool is_library = file.starts_with("tools/session/");
  if ((file.starts_with("tools/") && !is_library) || file.starts_with("tests/")) return "";
  static const std::regex kSpeech(
      R"re(\b(exit|_Exit|quick_exit|abort|printf|fprintf|puts|putchar|perror)\s*\(|\b(cout|cerr|clog)\b)re");
  const std::string code = line.substr(0, line.find("//"));
  return std::regex_search(code, kSpeech) ? file + " speaks or ends the program: " + line : "";
}

/// Structs, classes, unions and enums that the file defines with external linkage, by their whole
/// names, as clang-format writes them: at the beginning of a line. Specialisations are left out.
inline std::vector<std::string> defined_types(const Lines& lines) {
  static const std::regex kOpens(R"re(^(?:inline )?namespace\s*([\w:]*)\s*\{)re");
  static const std::regex kType(
      R"re(^(?:struct|class|union|enum|enum class) (?:alignas\(\w+\) )?(\w+)(?: final)?(?: : [^;]*)?(?: \{.*)?$)re");
  std::vector<std::string> scopes, types;
  std::smatch match;
  for (const std::string& line : lines) {
    if (std::regex_search(line, match, kOpens) && line.find('}') == std::string::npos)
      scopes.push_back(match[1]);
    else if (line.starts_with("}  // namespace") && !scopes.empty())
      scopes.pop_back();
    else if (std::regex_match(line, match, kType) &&
             std::find(scopes.begin(), scopes.end(), "") == scopes.end()) {
      std::string name;
      for (const std::string& scope : scopes) name += scope + "::";
      types.push_back(name + match[1].str());
    }
  }
  return types;
}

}  // namespace tessera
