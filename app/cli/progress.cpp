// SPDX-License-Identifier: MIT
#include "app/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace airclay {
namespace {

volatile std::sig_atomic_t caught_signal = 0;

}  // namespace

Progress::Progress(std::string what, int steps, bool shown)
    : what_(std::move(what)), steps_(std::max(steps, 1)), shown_(shown && isatty(STDERR_FILENO)) {
  struct sigaction action {};
  action.sa_handler = [](int signal) { caught_signal = signal; };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, &previous_interrupt_);
  sigaction(SIGTERM, &action, &previous_end_);
}

Progress::~Progress() {
  if (shown_) std::fputs("\r\033[K", stderr);
  sigaction(SIGINT, &previous_interrupt_, nullptr);
  sigaction(SIGTERM, &previous_end_, nullptr);
}

void Progress::advance() {
  ++done_;
  show(done_ == steps_);
}

void Progress::reach(double share) {
  done_ = static_cast<int>(share * steps_);
  show(false);
}

void Progress::show(bool now_too) {
  if (caught_signal) throw Interrupted{caught_signal};
  if (!shown_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - drawn_ < std::chrono::milliseconds(50) && !now_too) return;  // limit to 20 Hz
  drawn_ = now;
  draw();
}

void Progress::draw() const {
  constexpr int width = 40;
  const int filled = static_cast<int>(static_cast<long>(width) * std::min(done_, steps_) / steps_);
  const std::string bar = std::string(filled, '=') + std::string(width - filled, ' ');
  std::fprintf(stderr, "\r\033[K%s [%s] %d of %d", what_.c_str(), bar.c_str(), done_, steps_);
  std::fflush(stderr);
}

}  // namespace airclay
