// The times of frames in transforms files: `time`, or another key where the images show that it is
// one.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ingest/poses/stated_object.h"
#include "ingest/prepared/transforms_json.h"

namespace tessera {

/// `time` as a number or as the text of one. Errors: InputError: anything else.
std::optional<double> stated_time(const StatedObject& entry);

/// The values that an entry has under other keys whose words are those of times (`timestamp_ns`,
/// `frameIndex` …); NaN for what is no number. They count as read.
std::map<std::string, double> other_times_of(const StatedObject& entry);

/// Sets TransformsFrame::time of a capture that states no `time`, and notes the key. A key counts
/// where all frames have a number under it, and images of several views share its values, or the
/// images of a view have several; times in any unit come before numbers of frames, which are
/// counted at 30 a second. Photos of a scene that stands still have such keys, too: they stay
/// without times, and a note names the keys. `views`: view_numbers of the frames. Errors:
/// InputError that names the keys and `time`: keys that differ in their order, numbers that count
/// the images of all cameras, and views that mostly have several images that differ without any
/// such key.
void choose_times(TransformsCapture& capture, const std::vector<int>& views);

}  // namespace tessera
