// SPDX-License-Identifier: MIT
#include "engine/core/task.h"

namespace airclay {
namespace {

thread_local Task* told = nullptr;

}  // namespace

Task::Task() : before_(told) {
  told = this;
}

Task::~Task() {
  told = before_;
}

void reportProgress(double share) {
  if (told) told->onProgress(share);
}

void reportProgress(std::size_t done, std::size_t total) {
  if (told && done % 4096 == 0) told->onProgress(static_cast<double>(done) / static_cast<double>(total));
}

}  // namespace airclay
