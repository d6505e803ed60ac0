// The table of the cameras of a rig: what each has recorded, how its pose and clock are known, and
// how it differs from the others. camera_table_text.h writes it.
#pragma once
#include <string>
#include <vector>

#include "ingest/camera_row.h"
#include "ingest/checks/colour_gains.h"
#include "ingest/checks/orientation.h"

namespace tessera {

struct Capture;

/// One row a clip, in the order of the names, without gains and rolls; empty of fewer than two
/// clips. `capture`: after choose_frames(). Odd is a camera of another size or rate than most, one
/// that films a part of the clip, one without a clock where others have one, and one whose pose
/// error is three times the median and 1 pixel or more. Rate and pose error are reasons to leave it
/// out.
std::vector<CameraRow> camera_table(const Capture& capture);

/// Adds the gains of the cameras with enough colours, relative to the median camera. Below 0.8 and
/// above 1.25 a camera is odd.
void put_gains(const std::vector<CameraGain>& gains, std::vector<CameraRow>& rows);
/// Adds the rolls that are known. From 45 degrees on a camera is odd.
void put_rolls(const std::vector<CameraRoll>& rolls, std::vector<CameraRow>& rows);

/// "leave out cam01 (other rate): --cameras cam00,cam02"; empty where no camera is to be left out,
/// and where too few, or fewer than half of them, would be left: a camera that is a little off
/// helps more than one that is not there.
std::string leave_out_line(const std::vector<CameraRow>& rows);

}  // namespace tessera
