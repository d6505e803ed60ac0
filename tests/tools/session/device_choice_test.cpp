// Every state of CUDA on a machine: the chosen backend, the messages and the errors. The probe is
// tested in backend_device_test.cpp.
#include "tools/session/device_choice.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "kernels/base/errors.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

/// Two cards, of which the first can be used.
DeviceFacts two_cards() {
  DeviceFacts facts;
  facts.has_driver_module = true;
  facts.cuda.failure = CudaFailure::kNone;
  facts.cuda.runtime_version = 13000;
  facts.cuda.driver_version = 13000;
  facts.cuda.architectures = {90};
  facts.cuda.devices = {{"NVIDIA H200", 90}, {"NVIDIA GeForce RTX 4090", 89}};
  return facts;
}

DeviceFacts failing(CudaFailure failure) {
  DeviceFacts facts = two_cards();
  facts.cuda.failure = failure;
  return facts;
}

/// The stated reason where the user made no choice.
std::string reason_on_cpu(const DeviceFacts& facts, bool is_expected = false) {
  const DeviceChoice choice = choose_device({}, facts);
  EXPECT_FALSE(choice.cuda);
  EXPECT_EQ(choice.is_expected, is_expected) << choice.reason;
  return choice.reason;
}

template <class Error>
std::string refusal(const BackendWish& wish, const DeviceFacts& facts) {
  try {
    choose_device(wish, facts);
  } catch (const Error& error) {
    return error.what();
  }
  return "was not refused";
}

TEST(DeviceChoice, ADeviceThatCanBeUsedIs) {
  const DeviceChoice choice = choose_device({}, two_cards());
  EXPECT_TRUE(choice.cuda);
  EXPECT_EQ(choice.reason, "device 0 of 2 can be used");
  EXPECT_TRUE(choose_device({"cuda", {}}, two_cards()).cuda);
  const DeviceChoice cpu = choose_device({"cpu", {}}, two_cards());
  EXPECT_FALSE(cpu.cuda);
  EXPECT_TRUE(cpu.is_expected);
  EXPECT_EQ(cpu.reason, "--backend cpu");
}

TEST(DeviceChoice, WithoutAnNvidiaDeviceThereIsNoWarning) {
  EXPECT_EQ(reason_on_cpu({}, true), "this build has no CUDA backend");
  DeviceFacts bare;
  bare.cuda.failure = CudaFailure::kNoDriver;
  EXPECT_EQ(reason_on_cpu(bare, true), "no NVIDIA driver is installed");
}

// Bug put back: every failure is expected, nothing warned of; seen to fail, as the next ones.
TEST(DeviceChoice, ABuildWithoutCudaBesideADriverIsWorthAWarning) {
  DeviceFacts facts;
  facts.has_driver_module = true;
  EXPECT_EQ(reason_on_cpu(facts),
            "this build has no CUDA backend, but the machine has an NVIDIA driver; configure with "
            "-DTESSERA_CUDA=ON");
}

TEST(DeviceChoice, AContainerWithoutItsGpuIsNamed) {
  EXPECT_EQ(reason_on_cpu(failing(CudaFailure::kNoDriver)),
            "the library of the NVIDIA driver (libcuda.so.1) is not found; install it, or start "
            "the container with its GPU (docker run --gpus all)");
}

// Bug put back: the versions the other way round; seen to fail.
TEST(DeviceChoice, AnOldDriverIsNamedWithBothVersions) {
  DeviceFacts facts = failing(CudaFailure::kOldDriver);
  facts.cuda.driver_version = 12040;
  EXPECT_EQ(reason_on_cpu(facts),
            "the NVIDIA driver is too old: it supports CUDA 12.4, this build needs 13.0; update "
            "the driver");
}

TEST(DeviceChoice, HiddenDevicesAreExplained) {
  DeviceFacts facts = failing(CudaFailure::kNoDevice);
  facts.cuda.devices.clear();
  EXPECT_EQ(reason_on_cpu(facts), "the NVIDIA driver shows no device");
  facts.visible_devices = "";
  EXPECT_EQ(reason_on_cpu(facts), "the NVIDIA driver shows no device: CUDA_VISIBLE_DEVICES is ''");
}

TEST(DeviceChoice, AMissingKernelImageNamesCardBuildAndRemedy) {
  DeviceFacts facts = failing(CudaFailure::kNoKernels);
  facts.cuda.tried = 1;
  EXPECT_EQ(reason_on_cpu(facts),
            "this build has kernels for sm_90 only, the card NVIDIA GeForce RTX 4090 is sm_89; "
            "rebuild with -DCMAKE_CUDA_ARCHITECTURES=89, or with --preset gpu for every card");
  facts.cuda.architectures = {80, 90};
  EXPECT_NE(reason_on_cpu(facts).find("kernels for sm_80, sm_90 only"), std::string::npos);
}

TEST(DeviceChoice, NoMemoryAndOtherErrorsAreNamed) {
  DeviceFacts facts = failing(CudaFailure::kNoMemory);
  EXPECT_EQ(reason_on_cpu(facts),
            "device 0 (NVIDIA H200) has too little free memory to begin with; end what runs on it "
            "(see nvidia-smi), or choose another one by --gpu");
  facts.cuda.devices.pop_back();
  EXPECT_EQ(reason_on_cpu(facts).find("--gpu"), std::string::npos);
  facts = failing(CudaFailure::kOther);
  facts.cuda.error = "system not yet initialized";
  EXPECT_EQ(reason_on_cpu(facts), "CUDA reports: system not yet initialized");
}

// Bug put back: a wish for a device ends on the CPU; seen to fail.
TEST(DeviceChoice, WhatWasAskedForIsNeverReplaced) {
  DeviceFacts facts = failing(CudaFailure::kOldDriver);
  facts.cuda.driver_version = 12040;
  EXPECT_EQ(refusal<DeviceError>({"cuda", {}}, facts),
            "CUDA cannot be used: the NVIDIA driver is too old: it supports CUDA 12.4, this build "
            "needs 13.0; update the driver; --backend cpu does without");
  EXPECT_EQ(refusal<DeviceError>({"auto", 0}, {}),
            "--gpu 0 cannot be used: this build has no CUDA backend");
}

TEST(DeviceChoice, AnUnknownNumberIsRefusedWithThoseThatExist) {
  DeviceFacts facts = two_cards();
  facts.cuda.tried = 2;
  EXPECT_EQ(refusal<InputError>({"auto", 2}, facts),
            "--gpu 2: there is no such CUDA device, expected one of: 0 (NVIDIA H200), 1 (NVIDIA "
            "GeForce RTX 4090)");
  facts.visible_devices = "3,5";
  const std::string message = refusal<InputError>({"cuda", 7}, facts);
  EXPECT_TRUE(message.ends_with("; CUDA_VISIBLE_DEVICES is '3,5'")) << message;
  facts.cuda.tried = 1;
  EXPECT_TRUE(choose_device({"auto", 1}, facts).cuda);
}

TEST(DeviceChoice, NamesAndNumbersAreParsed) {
  EXPECT_EQ(parse_backend("auto").name, "auto");
  EXPECT_FALSE(parse_backend("cuda").gpu);
  EXPECT_EQ(parse_backend("cuda:12").name, "cuda");
  EXPECT_EQ(parse_backend("cuda:12").gpu, 12);
  for (const char* wrong : {"gpu", "", "auto:", "auto:-1", "cuda:1x", "cuda:99999999999", "cpu:0"})
    EXPECT_THROW(parse_backend(wrong), InputError) << wrong;
}

// Bugs put back, each seen to fail: the group of the job alone looked at; the unlimited "max" taken
// for 0; version 1 not known.
TEST(MachineMemory, IsTheLeastThatTheGroupsOfAJobAllow) {
  const ScratchFolder scratch;
  const auto write = [&](const std::string& file, const std::string& text) {
    std::filesystem::create_directories((scratch / file).parent_path());
    std::ofstream(scratch / file) << text;
  };
  write("memory.max", "max\n");
  write("system.slice/job_12/memory.max", "64000000\n");
  write("system.slice/job_12/step_0/memory.max", "max\n");
  EXPECT_EQ(memory_limit("0::/system.slice/job_12/step_0\n", scratch.path()), 64000000);
  EXPECT_EQ(memory_limit("0::/\n", scratch.path()), std::nullopt);
  EXPECT_EQ(memory_limit("", scratch.path()), std::nullopt);
  write("memory/docker/ab/memory.limit_in_bytes", "9000000\n");
  EXPECT_EQ(memory_limit("11:cpu,cpuacct:/docker/ab\n9:memory:/docker/ab\n", scratch.path()),
            9000000);
  EXPECT_GT(machine_memory(), 1 << 20);
}

}  // namespace
}  // namespace tessera::testing
