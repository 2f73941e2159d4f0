// SPDX-License-Identifier: MIT
// Runs the tests; after each one, the validation layer must have been silent and every guard word whole.
#include <memory>

#include "tests/support/gpu_fixture.h"

namespace airclay {
namespace {

std::unique_ptr<Gpu>& sharedGpu() {
  static std::unique_ptr<Gpu> gpu;
  return gpu;
}

class GpuListener : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo&) override {
    if (!sharedGpu()) return;
    const std::vector<std::string>& messages = sharedGpu()->validationMessages();
    for (; reported_ < messages.size(); ++reported_) ADD_FAILURE() << "validation: " << messages[reported_];
    EXPECT_EQ(sharedGpu()->damagedGuards(), 0) << "a kernel wrote outside its buffer";
  }
  std::size_t reported_ = 0;
};

}  // namespace

Gpu& testGpu() {
  if (!sharedGpu()) {
    GpuOptions options;
    options.validation = true;
    options.guards = true;
    sharedGpu() = std::make_unique<Gpu>(options);
  }
  return *sharedGpu();
}

}  // namespace airclay

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new airclay::GpuListener);
  const int result = RUN_ALL_TESTS();
  airclay::sharedGpu().reset();
  return result;
}
