// What: advice for options that users of other programs type, or of other commands.
// Not: options; nothing here is accepted.
#pragma once
#include <string>

namespace tessera {

/// What to do instead of the unknown option `typed` of `command`; "" where nothing is known.
std::string usage_advice(const std::string& command, const std::string& typed);

/// Our name of an option that others call `typed`; "" where nothing is known.
std::string our_option_name(const std::string& typed);

}  // namespace tessera
