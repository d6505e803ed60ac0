// The number of serial sections of each thread.
#include "kernels/base/serial_section.h"

namespace tessera {
namespace {

thread_local int sections = 0;

}  // namespace

SerialSection::SerialSection() {
  ++sections;
}
SerialSection::~SerialSection() {
  --sections;
}
bool SerialSection::is_here() {
  return sections > 0;
}

}  // namespace tessera
