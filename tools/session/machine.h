// Facts of this machine and of this process, from the system. CUDA devices are those of
// kernels/backend.h.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

/// Bytes of memory that programs can have in all.
int64_t machine_memory();

/// The name of the processor, as /proc/cpuinfo has it; "unknown" where it has none.
std::string cpu_name();

/// The words by which this process was started; empty where the system does not list them.
std::vector<std::string> command_line();

/// Now, in UTC and as ISO 8601 has it: "2026-11-24T09:30:00Z".
std::string utc_time();

}  // namespace tessera
