// SPDX-License-Identifier: MIT
#include "engine/core/task.h"

namespace airclay {
namespace {

thread_local LongWork* told = nullptr;

}  // namespace

LongWork::LongWork() : before_(told) {
  told = this;
}

LongWork::~LongWork() {
  told = before_;
}

void workGoesOn(double share) {
  if (told) told->goesOn(share);
}

void workGoesOn(std::size_t done, std::size_t total) {
  if (told && done % 4096 == 0) told->goesOn(static_cast<double>(done) / static_cast<double>(total));
}

}  // namespace airclay
