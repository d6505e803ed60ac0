// One camera of a rig as the table of cameras shows it, before hours of training.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct CameraRow {
  std::string name;
  int width = 0, height = 0;         // of the upright images of its file, pixels
  double frames_per_second = 0;      // by the median distance of its frames; 0: not known
  int64_t frames_in_file = 0;        // that are shown
  int64_t frames_kept = 0;           // of them in the scene
  std::string pose_source;           // "stated" or "COLMAP"
  std::optional<double> pose_error;  // mean reprojection error of the points that COLMAP found with
                                     // it, pixels; absent of stated and of held-out cameras
  double clock_offset = 0;           // seconds added to its times
  double clock_offset_frames = 0;    // the same in its frames; 0 where the rate is not known
  double clock_error = 0;            // its standard error in its frames; 0: stated, not known
  double readout = 0;                // of its rolling shutter as it is stated, seconds
  std::string clock_source;          // "stated", "container", "audio", "motion", "none"
  std::optional<double> gain;      // its 8-bit values by the median camera's, mean of R G B; absent
                                   // where too little is shared, of held-out cameras, not measured
  std::optional<double> roll;      // clockwise turn of its image against the rig's up, degrees
  bool test = false;               // held out
  bool leave_out = false;          // the others alone make the better scene
  std::vector<std::string> notes;  // what is odd: "other rate", "dark"; empty: nothing

  bool is_odd() const { return !notes.empty(); }
};

}  // namespace tessera
