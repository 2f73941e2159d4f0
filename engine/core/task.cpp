// SPDX-License-Identifier: MIT
#include "engine/core/task.h"

namespace airclay {
namespace {

thread_local Task* current = nullptr;

}  // namespace

Task::Task() : previous_(current) {
  current = this;
}

Task::~Task() {
  current = previous_;
}

void reportProgress(double fraction) {
  if (current) current->onProgress(fraction);
}

void reportProgress(std::size_t done, std::size_t total) {
  if (current && done % 4096 == 0)
    current->onProgress(static_cast<double>(done) / static_cast<double>(total));
}

}  // namespace airclay
