// The report of the device probe, against the behaviour of the devices of this machine. The choice
// of a device is tested in tests/tools/session/device_choice_test.cpp.
#include "kernels/device_probe.h"
#include "tests/support/backends.h"
#include "tests/support/render.h"

namespace tessera::testing {
namespace {

TESSERA_ON_DEVICES(DeviceOnly);

TEST(DeviceProbe, AgreesWithWhatCanBeMade) {
  const CudaProbe probe = probe_cuda(0);
  try {
    make_cuda_backend();
    EXPECT_EQ(probe.failure, CudaFailure::kNone) << probe.error;
  } catch (const DeviceError& error) {
    EXPECT_NE(probe.failure, CudaFailure::kNone) << error.what();
  }
}

TEST_P(DeviceOnly, TheProbeNamesDevicesVersionsAndKernels) {
  const CudaProbe probe = probe_cuda(0);
  EXPECT_EQ(probe.failure, CudaFailure::kNone) << probe.error;
  ASSERT_FALSE(probe.devices.empty());
  EXPECT_EQ(backend().name(), "cuda, " + probe.devices.front().name);
  EXPECT_GE(probe.devices.front().architecture, 75);
  EXPECT_GE(probe.runtime_version, 12040);
  EXPECT_GE(probe.driver_version / 1000, probe.runtime_version / 1000);
  ASSERT_FALSE(probe.architectures.empty());
  for (const int architecture : probe.architectures) EXPECT_GE(architecture, 75);
}

TEST_P(DeviceOnly, ANumberBeyondTheLastIsCountedAndNotTried) {
  const CudaProbe probe = probe_cuda(1000);
  EXPECT_EQ(probe.failure, CudaFailure::kNone) << probe.error;
  EXPECT_FALSE(probe.devices.empty());
  EXPECT_THROW(make_cuda_backend(1000), DeviceError);
}

// With two cards this shows that --gpu means the card: bug to put back: the number is not used.
TEST_P(DeviceOnly, EveryDeviceDrawsTheSame) {
  const CudaProbe probe = probe_cuda(0);
  const TestScene<float> scene = random_scene(50, 50, 0.2, 91).as<float>();
  const std::vector<float> expected = render(scene, backend()).colour;
  for (int i = 0; i < int(probe.devices.size()); ++i) {
    const CudaProbe tried = probe_cuda(i);
    if (tried.failure != CudaFailure::kNone) continue;
    const std::unique_ptr<Backend> other = make_cuda_backend(i);
    EXPECT_EQ(other->name(), "cuda, " + tried.devices[size_t(i)].name);
    const std::vector<float> colour = render(scene, *other).colour;
    if (tried.devices[size_t(i)].architecture == probe.devices.front().architecture) {
      EXPECT_EQ(colour, expected) << i;
    }
  }
  make_cuda_backend(0);  // the calling thread's device again
}

}  // namespace
}  // namespace tessera::testing
