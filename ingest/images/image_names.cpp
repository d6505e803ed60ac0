// Names are read word by word, without regard to case.
#include "ingest/images/image_names.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "ingest/files/text_scan.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

using std::string_view;

constexpr string_view kSeparators = " ._-", kLetters = "abcdefghijklmnopqrstuvwxyz";
constexpr std::array<string_view, 10> kCameraWords = {"cam",    "camera", "kinect", "gopro", "view",
                                                      "device", "sensor", "cn",     "hd",    "vga"};
constexpr std::array<string_view, 5> kFrameWords = {"frame", "image", "img", "f", "t"};

constexpr size_t kMostDigits = 20;  // more than a number of 64 bits has

bool is_number(string_view text, size_t most) {
  return take_number(text, most) && text.empty();
}

/// "00", "00_12"
bool is_camera_number(string_view text) {
  if (!take_number(text, 5)) return false;
  return text.empty() || (take_one_of(text, "_-") && is_number(text, 3));
}

/// Whether `text` is `word`, an optional separator, an optional letter and what `rest` accepts.
template <typename Rest>
bool is_after_word(string_view text, string_view word, string_view separators, Rest&& rest) {
  if (!take(text, word)) return false;
  take_one_of(text, separators);
  take_one_of(text, kLetters);
  return rest(text);
}

/// Takes "0012" or "frame_12"; nothing where `text` begins otherwise.
std::optional<int64_t> take_frame_number(string_view& text) {
  if (const auto number = take_number(text, kMostDigits)) return number;
  for (const string_view word : kFrameWords) {
    string_view rest = text;
    if (!take(rest, word)) continue;
    take_one_of(rest, "_-");
    const auto number = take_number(rest, kMostDigits);
    if (!number) continue;
    text = rest;
    return number;
  }
  return std::nullopt;
}

/// "0012_cam00", "frame_12-view1" in lower case; the camera as `stem` spells it.
std::optional<NumberedName> camera_last(const std::string& stem, string_view text) {
  const auto number = take_frame_number(text);
  if (!number || !take_one_of(text, "_-")) return std::nullopt;
  for (const string_view camera : {"cam", "camera", "view"})
    if (is_after_word(text, camera, "_-", [](string_view n) { return is_number(n, 4); }))
      return NumberedName{stem.substr(stem.size() - text.size()), *number};
  return std::nullopt;
}

/// How many characters of `text`, which is in lower case, stand before the word of frames that it
/// ends with, after a digit or a separator; all where it does not end so.
size_t length_without_frame_word(string_view text) {
  for (const string_view word : kFrameWords) {
    if (!text.ends_with(word)) continue;
    const string_view before = text.substr(0, text.size() - word.size());
    if (before.empty() || (before.back() >= '0' && before.back() <= '9') ||
        kSeparators.find(before.back()) != string_view::npos)
      return before.size();
  }
  return text.size();
}

}  // namespace

bool is_camera_name(const std::string& name) {
  const std::string text = lower_case(name);
  for (const string_view letter : {"", "c", "v"})
    if (string_view rest = text; take(rest, letter) && is_camera_number(rest)) return true;
  return std::any_of(kCameraWords.begin(), kCameraWords.end(), [&](string_view word) {
    return is_after_word(text, word, " _-", is_camera_number);
  });
}

std::optional<NumberedName> parse_stem(const std::string& stem) {
  const std::string text = lower_case(stem);
  if (auto name = camera_last(stem, text)) return name;
  size_t begin = text.size();
  while (begin > 0 && text[begin - 1] >= '0' && text[begin - 1] <= '9') --begin;
  string_view digits = string_view(text).substr(begin);
  const auto number = take_number(digits, kMostDigits);
  if (!number) return std::nullopt;
  const auto without_separators = [&](size_t length) {
    while (length > 0 && kSeparators.find(text[length - 1]) != string_view::npos) --length;
    return length;
  };
  size_t length = without_separators(begin);
  length = without_separators(length_without_frame_word(string_view(text).substr(0, length)));
  return NumberedName{stem.substr(0, length), *number};
}

}  // namespace tessera
