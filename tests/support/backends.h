// The float backends of a test: "cpu" always, "cuda" where there is a device. Expected values come
// from the CPU in double.
#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "kernels/backend.h"
#include "kernels/base/errors.h"

namespace tessera::testing {

/// A test for every backend; where a backend is absent it skips with the reason.
class EveryBackend : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!is_cuda()) {
      backend_ = make_cpu_backend();
      return;
    }
    try {
      backend_ = make_cuda_backend();
    } catch (const DeviceError& error) {
      GTEST_SKIP() << error.what();
    }
  }
  bool is_cuda() const { return std::string(GetParam()) == "cuda"; }
  Backend& backend() { return *backend_; }
  Memory& memory() { return backend_->memory(); }

 private:
  std::unique_ptr<Backend> backend_;
};

/// A test of what only a device does.
class DeviceOnly : public EveryBackend {};

inline std::string backend_label(const ::testing::TestParamInfo<const char*>& info) {
  return info.param;
}

}  // namespace tessera::testing

#define TESSERA_ON_EVERY_BACKEND(suite) \
  INSTANTIATE_TEST_SUITE_P(On, suite, ::testing::Values("cpu", "cuda"), backend_label)
#define TESSERA_ON_DEVICES(suite) \
  INSTANTIATE_TEST_SUITE_P(On, suite, ::testing::Values("cuda"), backend_label)
