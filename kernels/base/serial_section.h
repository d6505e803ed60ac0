// Work beside other work: loops of one thread that leave the other cores alone.
#pragma once

namespace tessera {

/// While one of these lives, parallel_for of this thread runs its ranges one after another here.
class SerialSection {
 public:
  SerialSection();
  SerialSection(const SerialSection&) = delete;
  SerialSection& operator=(const SerialSection&) = delete;
  ~SerialSection();

  /// Whether this thread is in one.
  static bool is_here();
};

}  // namespace tessera
