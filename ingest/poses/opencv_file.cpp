// Walks the nodes of cv::FileStorage, whose exceptions become InputError.
#include "ingest/poses/opencv_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int kMostLevels = 20;

json tree_of(const cv::FileNode& node, int levels) {
  if (levels == 0) throw InputError("is nested too deeply");
  if (node.isInt()) return int(node);
  if (node.isReal()) return double(node);
  if (node.isString()) return std::string(node);
  if (node.isMap()) {
    json tree = json::object();
    for (const cv::FileNode& child : node) tree[child.name()] = tree_of(child, levels - 1);
    return tree;
  }
  json tree = node.isSeq() ? json::array() : json();
  if (node.isSeq())
    for (const cv::FileNode& child : node) tree.push_back(tree_of(child, levels - 1));
  return tree;
}

}  // namespace

json read_opencv_tree(const std::filesystem::path& file) {
  constexpr uintmax_t kMostBytes = uintmax_t{16} << 20;
  std::error_code unreadable;
  const uintmax_t bytes = std::filesystem::file_size(file, unreadable);
  std::string reason = "it cannot be opened";
  if (unreadable) {
    reason = unreadable.message();
  } else if (bytes > kMostBytes) {
    reason = "it has more than 16 MiB";
  } else {
    try {
      const cv::FileStorage storage(read_plain_text(file),
                                    cv::FileStorage::READ | cv::FileStorage::MEMORY);
      if (storage.isOpened()) return tree_of(storage.root(), kMostLevels);
    } catch (const cv::Exception& error) {
      reason = error.err;
    } catch (const InputError& error) {
      reason = error.what();
    }
  }
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  throw InputError(fmt::format(
      "{}: is no file of cv::FileStorage with a calibration ({}); write it with OpenCV, or as JSON",
      file.string(), reason));
}

}  // namespace tessera
