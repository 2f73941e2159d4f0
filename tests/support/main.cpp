// SPDX-License-Identifier: MIT
// Runs the tests. Fails a test after which the validation layer has reported a message or a guard word is
// overwritten. Fails the run if it leaves files in the temporary folder.
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "tests/support/gpu_fixture.h"
#include "tests/support/temporary_folder.h"

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

/// The temporary folder of this process and of the programs that it runs.
class TemporaryRoot {
 public:
  TemporaryRoot() {
    folder_.emplace();
    // some tests run as another user, who must reach their files
    std::filesystem::permissions(folder_->path(), std::filesystem::perms(0755));
    setenv("TMPDIR", folder_->path().c_str(), 1);
  }
  /// Runs after the destructors of all static objects that tests create.
  ~TemporaryRoot() {
    bool empty = true;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_->path())) {
      std::fprintf(stderr, "%s: left in the temporary folder\n", entry.path().c_str());
      empty = false;
    }
    folder_.reset();
    if (!empty) _exit(1);
  }

 private:
  std::optional<TemporaryFolder> folder_;
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
  static const airclay::TemporaryRoot temporary_root;  // first, so that it is destroyed last
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new airclay::GpuListener);
  const int result = RUN_ALL_TESTS();
  airclay::sharedGpu().reset();
  return result;
}
