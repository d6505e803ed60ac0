// An object of a calibration or of a transforms file, which knows which of its keys were read: what
// is stated of a camera is taken, refused or named, and never dropped in silence.
#pragma once
#include <functional>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

class StatedObject {
 public:
  /// `object`, which outlives this, may be no object: it has no keys then. `where` begins errors.
  StatedObject(const nlohmann::json& object, std::string where)
      : object_(&object), where_(std::move(where)) {}

  const std::string& where() const { return where_; }
  /// The value at `key`, which counts as read from now on; null where there is none.
  const nlohmann::json* at(const std::string& key) const;
  bool has(const std::string& key) const { return at(key) != nullptr; }

  struct Member {
    std::string key;  // as it is stated
    const nlohmann::json* value = nullptr;
    explicit operator bool() const { return value != nullptr; }
  };
  /// The first whose key is one of `names` but for case and separators, in the order of `names`:
  /// "cameramatrix" is camera_matrix and CameraMatrix. It counts as read.
  Member named(std::initializer_list<std::string_view> names) const;
  /// The first, in the order of keys, whose plain key and value fit. It counts as read.
  Member first(
      const std::function<bool(const std::string& plain, const nlohmann::json&)>& fits) const;

  /// Nothing or "" where there is no such key. Errors: InputError: no finite number; no text.
  std::optional<double> number(const std::string& key) const;
  std::string text(const std::string& key) const;
  /// Whether the key is there and is true.
  bool is_true(const std::string& key) const;

  /// Counts a key as read.
  void take(const std::string& key) const { read_.insert(key); }
  /// All that there is, in the order of keys. Counts nothing as read.
  std::vector<Member> members() const;
  /// What has not been read, but for values that say nothing: null, false, zeros, "", empty lists.
  std::vector<Member> rest() const;

 private:
  const nlohmann::json* object_;
  std::string where_;
  mutable std::set<std::string> read_;
};

/// Letters in lower case and digits alone: what keys are compared by.
std::string plain_key(std::string_view key);

/// Whether a key is of words of `heads` and `others` alone, one of them of `heads`: "frameIndex"
/// and "frame_idx" are of {frame} and {index, idx}.
bool is_of_words(std::string_view key, const std::set<std::string>& heads,
                 const std::set<std::string>& others);

/// Adds the keys of lists and objects that were not read to `unread`. Errors: InputError that names
/// the key where it speaks of a lens or of a pose: the camera is another one without it.
void account_for(const StatedObject& object, std::set<std::string>& unread);

/// Adds a line that names such keys of a file, where there are some.
void note_unread_keys(const std::string& where, const std::set<std::string>& unread,
                      std::vector<std::string>& notes);

}  // namespace tessera
