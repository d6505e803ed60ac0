// Names the cameras of a rig that are not as most of them are.
#pragma once
#include <string>
#include <vector>

namespace tessera {

/// "cam03 is HLG, cam05 is PQ, the others SDR" of the verb "is"; empty where all texts are alike.
/// The others' text is that of most cameras, the first one's of equally many. `cameras`: names;
/// `texts`: what each is or has.
std::string odd_cameras(const std::vector<std::string>& cameras,
                        const std::vector<std::string>& texts, const char* verb);

}  // namespace tessera
