// Keys are told by their words, so that no list of spellings is needed to notice one.
#include "ingest/poses/stated_object.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>

#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

// How the words of a key begin that speaks of a lens, of a pose, and of what names either.
constexpr std::array<std::string_view, 6> kLensWords{"dist",   "undist",     "coef",
                                                     "radial", "tangential", "fisheye"};
constexpr std::array<std::string_view, 11> kPoseWords{"rot",  "quat", "euler",     "extrinsic",
                                                      "pose", "w2c",  "c2w",       "world",
                                                      "skew", "lens", "projection"};
constexpr std::array<std::string_view, 5> kNamingWords{"distort", "projection", "convention",
                                                       "coordinate", "handed"};
/// Of such keys those that mean something else, or images that a program has rectified.
constexpr std::array<std::string_view, 5> kOtherWords{"distance", "distrib", "rect", "error",
                                                      "applied"};

bool is_upper(char c) {
  return c >= 'A' && c <= 'Z';
}

bool is_letter(char c) {
  return is_upper(c) || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

/// "distCoef_2" → dist, coef, 2; "RTMatrix" → rt, matrix.
std::vector<std::string> words_of(std::string_view key) {
  std::vector<std::string> words;
  for (size_t i = 0; i < key.size(); ++i) {
    if (!is_letter(key[i])) continue;
    const bool after_break = i == 0 || !is_letter(key[i - 1]);
    const bool is_hump =
        is_upper(key[i]) && i > 0 &&
        (!is_upper(key[i - 1]) || (i + 1 < key.size() && is_letter(key[i + 1]) &&
                                   !is_upper(key[i + 1]) && !std::isdigit(key[i + 1])));
    if (after_break || is_hump) words.emplace_back();
    words.back() += is_upper(key[i]) ? char(key[i] - 'A' + 'a') : key[i];
  }
  return words;
}

template <class Words>
bool begins_with_one_of(const std::string& word, const Words& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](std::string_view beginning) { return word.starts_with(beginning); });
}

/// Whether the camera may be another one without that value.
bool is_telling(const std::string& key, const json& value) {
  const std::vector<std::string> words = words_of(key);
  const auto one_of = [&](const auto& beginnings) {
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
      return begins_with_one_of(word, beginnings);
    });
  };
  if (one_of(kOtherWords)) return false;
  if (value.is_number()) return one_of(kLensWords);
  if (value.is_string()) {
    // "camera_model" and "lens_type" speak of a lens, "model" and "type" alone of a product
    const bool is_kind = words.size() > 1 && (words.back() == "model" || words.back() == "type");
    return is_kind || one_of(kNamingWords);
  }
  return !value.is_boolean() && (one_of(kLensWords) || one_of(kPoseWords) || one_of(kNamingWords));
}

bool says_nothing(const json& value) {
  if (value.is_array() || value.is_object())
    return std::all_of(value.begin(), value.end(), says_nothing);
  if (value.is_number()) return value == 0;
  if (value.is_string()) return value == "" || value == "none" || value == "NONE";
  return value.is_null() || value == false;
}

}  // namespace

std::string plain_key(std::string_view key) {
  std::string plain;
  for (const char c : key)
    if (is_letter(c)) plain += is_upper(c) ? char(c - 'A' + 'a') : c;
  return plain;
}

const json* StatedObject::at(const std::string& key) const {
  if (!object_->is_object()) return nullptr;
  const auto found = object_->find(key);
  if (found == object_->end()) return nullptr;
  read_.insert(key);
  return &*found;
}

StatedObject::Member StatedObject::first(
    const std::function<bool(const std::string&, const json&)>& fits) const {
  if (object_->is_object())
    for (const auto& [key, value] : object_->items())
      if (fits(plain_key(key), value)) return {key, at(key)};
  return {};
}

StatedObject::Member StatedObject::named(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names)
    if (Member found = first([&](const std::string& key, const json&) { return key == name; }))
      return found;
  return {};
}

std::optional<double> StatedObject::number(const std::string& key) const {
  return has(key) ? finite_number(*object_, key.c_str(), where_) : std::nullopt;
}

std::string StatedObject::text(const std::string& key) const {
  return has(key) ? string_at(*object_, key.c_str(), where_) : "";
}

bool StatedObject::is_true(const std::string& key) const {
  const json* const value = at(key);
  return value != nullptr && value->is_boolean() && value->get<bool>();
}

std::vector<StatedObject::Member> StatedObject::members() const {
  std::vector<Member> all;
  if (object_->is_object())
    for (const auto& [key, value] : object_->items()) all.push_back({key, &value});
  return all;
}

std::vector<StatedObject::Member> StatedObject::rest() const {
  std::vector<Member> rest = members();
  std::erase_if(rest, [&](const Member& member) {
    return read_.contains(member.key) || says_nothing(*member.value);
  });
  return rest;
}

bool is_of_words(std::string_view key, const std::set<std::string>& heads,
                 const std::set<std::string>& others) {
  const std::vector<std::string> words = words_of(key);
  const auto is_head = [&](const std::string& word) { return heads.contains(word); };
  return std::any_of(words.begin(), words.end(), is_head) &&
         std::all_of(words.begin(), words.end(), [&](const std::string& word) {
           return is_head(word) || others.contains(word);
         });
}

void account_for(const StatedObject& object, std::set<std::string>& unread) {
  for (const auto& [key, value] : object.rest()) {
    if (is_telling(key, *value))
      throw InputError(fmt::format(
          "{}: {} is not understood, and it may change the camera; state it as docs/howto/"
          "calibration.md has it, or take it out if the images are as without it",
          object.where(), key));
    if (value->is_array() || value->is_object()) unread.insert(key);
  }
}

void note_unread_keys(const std::string& where, const std::set<std::string>& unread,
                      std::vector<std::string>& notes) {
  if (!unread.empty())
    notes.push_back(fmt::format("{}: not read: {}", where, fmt::join(unread, ", ")));
}

}  // namespace tessera
