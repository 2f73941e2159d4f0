// SPDX-License-Identifier: MIT
// Strokes from frames, checked against their definition.
#include "engine/clay/strokes.h"

#include <gtest/gtest.h>

#include <vector>

namespace airclay {
namespace {

/// Frames a tenth of a second apart, and their events.
struct Watched {
  StrokeDetector watch;
  int frame = 0;

  StrokeEvent see(int touched, bool held = true, bool tracked = true, const char* tool = "Push") {
    return watch.addFrame({0.1 * frame++, touched, held, tracked}, tool);
  }
};

TEST(Strokes, TouchStartsAndGapEndsAStroke) {
  Watched w;
  EXPECT_EQ(w.see(0), StrokeEvent::kNone);
  EXPECT_EQ(w.see(3), StrokeEvent::kStarted);  // 0.1 s
  EXPECT_TRUE(w.watch.active());
  EXPECT_EQ(w.watch.name(), "Push");
  EXPECT_EQ(w.see(5), StrokeEvent::kNone);                                   // 0.2 s: the last touch
  for (int i = 0; i < 3; ++i) EXPECT_EQ(w.see(0), StrokeEvent::kNone) << i;  // 0.3 to 0.5 s
  EXPECT_EQ(w.see(1), StrokeEvent::kNone);  // 0.6 s: the hand lifted for less than the gap
  for (int i = 0; i < 3; ++i) EXPECT_EQ(w.see(0), StrokeEvent::kNone) << i;  // 0.7 to 0.9 s
  w.frame = 11;
  EXPECT_EQ(w.see(0), StrokeEvent::kEnded);  // 1.1 s: 0.5 s after the touch
  EXPECT_FALSE(w.watch.active());
  EXPECT_EQ(w.watch.name(), "Push");
  EXPECT_EQ(w.see(0), StrokeEvent::kNone);
  EXPECT_EQ(w.see(2), StrokeEvent::kStarted);
}

TEST(Strokes, GapIsFourTenthsOfASecond) {
  for (const double gap_s : {0.39, 0.41}) {
    StrokeDetector watch;
    EXPECT_EQ(watch.addFrame({1, 1}, "Push"), StrokeEvent::kStarted);
    EXPECT_EQ(watch.addFrame({1 + gap_s, 0}, "Push"), gap_s < 0.4 ? StrokeEvent::kNone : StrokeEvent::kEnded);
  }
}

TEST(Strokes, SlowFramesAreNotAGap) {
  StrokeDetector watch;  // the paper's 3 Hz, and slower
  EXPECT_EQ(watch.addFrame({0, 1}, "Push"), StrokeEvent::kStarted);
  EXPECT_EQ(watch.addFrame({0.33, 1}, "Push"), StrokeEvent::kNone);
  EXPECT_EQ(watch.addFrame({1.33, 1}, "Push"), StrokeEvent::kNone);
}

TEST(Strokes, OpenClutchOrLostHandEndsAStroke) {
  Watched clutch;
  clutch.see(3);
  EXPECT_EQ(clutch.see(3, false), StrokeEvent::kEnded);
  EXPECT_EQ(clutch.see(3, false), StrokeEvent::kNone);  // touching with an open clutch is not a stroke
  EXPECT_EQ(clutch.see(3), StrokeEvent::kStarted);
  Watched lost;
  lost.see(3);
  EXPECT_EQ(lost.see(0, true, false), StrokeEvent::kEnded);
  EXPECT_EQ(lost.see(3, true, false), StrokeEvent::kNone);
  EXPECT_EQ(lost.see(3), StrokeEvent::kStarted);
}

TEST(Strokes, ToolChangeEndsAStrokeAndNamesTheNext) {
  Watched w;
  w.see(3);
  EXPECT_EQ(w.see(3, true, true, "Smooth"), StrokeEvent::kEnded);
  EXPECT_EQ(w.watch.name(), "Push");
  EXPECT_EQ(w.see(3, true, true, "Smooth"), StrokeEvent::kStarted);
  EXPECT_EQ(w.watch.name(), "Smooth");
}

TEST(Strokes, RestartedTakeEndsAStroke) {
  StrokeDetector watch;
  watch.addFrame({5, 1}, "Push");
  EXPECT_EQ(watch.addFrame({0, 1}, "Push"), StrokeEvent::kEnded);
  EXPECT_EQ(watch.addFrame({0.1, 1}, "Push"), StrokeEvent::kStarted);
}

TEST(Strokes, FinishEndsTheCurrentStrokeOnce) {
  StrokeDetector watch;
  EXPECT_EQ(watch.finish(), StrokeEvent::kNone);
  watch.addFrame({0, 1}, "Pull");
  EXPECT_EQ(watch.finish(), StrokeEvent::kEnded);
  EXPECT_EQ(watch.finish(), StrokeEvent::kNone);
  EXPECT_EQ(watch.name(), "Pull");
}

}  // namespace
}  // namespace airclay
