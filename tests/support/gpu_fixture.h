// SPDX-License-Identifier: MIT
// The device that all tests share: with the validation layer, synchronization checks, and guard words around
// every buffer. A validation message or an overwritten guard word fails the current test
// (tests/support/main.cpp).
#pragma once

#include <gtest/gtest.h>

#include "engine/gpu/gpu.h"

namespace airclay {

/// Created on first use, destroyed after the last test.
Gpu& testGpu();

}  // namespace airclay
