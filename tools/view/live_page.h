// The page that shows a training while it runs.
#pragma once
#include <string>

namespace tessera {

/// One HTML file. It has the player, `/api/player`, in a frame, and polls `/api/state`
/// every second and `/api/charts` every third one.
std::string live_page();

}  // namespace tessera
