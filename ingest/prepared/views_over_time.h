// What frames with equal views show about time, and which of the values of entries follow it.
#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "ingest/prepared/transforms_json.h"

namespace tessera {

/// Of frames whose images need not be there. The functions that take a key of
/// TransformsFrame::other_times need one that is on all frames.
class ViewsOverTime {
 public:
  using Frames = std::vector<size_t>;  // numbers of frames

  /// `views`: view_numbers of the frames. Both stay alive as long as this. Images of equal views
  /// are compared by their bytes.
  ViewsOverTime(const std::vector<TransformsFrame>& frames, const std::vector<int>& views);

  /// By view the frames of one split, where their images differ.
  const std::vector<Frames>& changing() const { return changing_; }
  size_t changing_frames() const;

  /// Whether all frames have a number under the key.
  bool is_on_all(const std::string& key) const;
  /// Whether frames have several values of the key.
  bool has_several(const std::string& key) const;
  /// Whether the key changes while views stay, or views share its values: it follows time.
  bool follows_time(const std::string& key) const;
  /// Whether the key counts the images of several cameras through, so that no two share a value.
  bool counts_through(const std::string& key) const;
  /// Whether a view has two images with one value.
  bool repeats(const std::string& key) const;
  /// Whether one key increases where the other decreases: within a view, or in the whole capture
  /// where no view has several images.
  bool disagree(const std::string& one, const std::string& other) const;

 private:
  double value(size_t frame, const std::string& key) const;
  std::set<double> values_of(const Frames& group, const std::string& key) const;
  size_t changing_with(const std::string& key) const;
  size_t sharing(const std::string& key) const;
  bool images_differ(const Frames& group) const;

  const std::vector<TransformsFrame>& frames_;
  const std::vector<int>& views_;
  std::vector<Frames> changing_;
};

}  // namespace tessera
