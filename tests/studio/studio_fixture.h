// SPDX-License-Identifier: MIT
// The studio as somebody uses it: the built program in a window on a display of its own, mouse and keyboard
// as a hand would move them. What it did is looked up in its log, its documents and its files; the validation
// layer watches throughout, and whatever it said would stand on standard error.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "engine/core/file_io.h"
#include "tests/support/desktop.h"
#include "tests/support/documents.h"
#include "tests/support/program.h"

namespace airclay {

class Studio : public testing::Test {
 protected:
  using json = nlohmann::json;
  using Words = std::vector<std::string>;

  void SetUp() override {
    if (!Desktop::possible())
      GTEST_SKIP() << "there is no Xvfb; third_party/packages.txt names what is needed";
    desktop.emplace();
  }

  std::string at(const std::string& name) const { return folder / name; }

  /// Opens the window; `words` follow `airclay sculpt`.
  void start(const Words& words) {
    std::filesystem::remove(log_file);
    Words all = {AIRCLAY_PROGRAM, "sculpt", "--log", log_file};
    all.insert(all.end(), words.begin(), words.end());
    std::map<std::string, std::string> environment = desktop->environment();
    environment["XDG_CONFIG_HOME"] = at("config");
    environment["XDG_STATE_HOME"] = at("state");
    environment["AIRCLAY_VALIDATION"] = "1";
    program.emplace(all, environment, folder / "output", folder / "errors");
    desktop->findWindow("^Airclay");
    ASSERT_TRUE(sees([](const json&) { return true; })) << errors();
  }
  void startWithoutHint(const Words& words) {
    folder.write("config/airclay/studio.toml", "first_run = false\n");
    start(words);
  }

  /// By the window manager, as with the window's own button.
  void close() {
    desktop->key("alt+F4");
    EXPECT_EQ(program->waitForExit(), 0);
    EXPECT_EQ(errors(), "");
  }

  std::string errors() const { return readWhole(folder / "errors", kMaxDocumentBytes); }

  /// The last whole line; null when there is none yet.
  json log() const {
    if (!std::filesystem::exists(log_file)) return nullptr;
    std::string text = readWhole(log_file, kMaxDocumentBytes);
    text.erase(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n'));
    return text.empty() ? json(nullptr) : json::parse(text.substr(text.rfind('\n') + 1));
  }
  /// Whether the log comes to say so.
  bool sees(const std::function<bool(const json&)>& expected, double deadline_s = kDeadlineS) {
    bool seen = false;
    const auto seenOrOver = [&] {
      const json line = log();
      seen = !line.is_null() && expected(line);
      return seen || !program->running();
    };
    waitUntil(seenOrOver, deadline_s);
    return seen;
  }
  bool seesCounts(int undo, int redo) {
    return sees([&](const json& line) {
      return line["undo"] == undo && line["redo"] == redo && line["sculpting"] == false;
    });
  }
  bool seesNote(const std::string& words) {
    return sees(
        [&](const json& line) { return line["note"].get<std::string>().find(words) != std::string::npos; });
  }

  /// The document as a crash would leave it: between two edits the file is whole. No other process can open
  /// it while the program has it, so it is a copy that is looked at.
  Document kept(const std::filesystem::path& file) const {
    const std::filesystem::path copy = folder / "copy.clay";
    std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
    return Document::open(copy);
  }

  /// What the display shows once nothing moves in its middle.
  Screenshot restingFrame() const {
    Screenshot shot = desktop->screenshot();
    const auto rests = [&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // finer half a second after a change
      const Screenshot before = std::exchange(shot, desktop->screenshot());
      return differingFraction(before, shot, kMiddle) == 0;
    };
    EXPECT_TRUE(waitUntil(rests));
    return shot;
  }
  static constexpr double kMiddle = 0.7;  // of the display, without panels and the document's name

  /// The mouse's hand comes from the clay's side, along the workspace's y, until it is well in the clay, and
  /// stays there: the stroke is under way.
  void pushIn() {
    desktop->key("6");
    desktop->moveTo(kFromX, kY);
    desktop->press();
    // How much of the way the first image of the press takes is the machine's pace.
    const auto touches = [&] { return log()["sculpting"] == true; };
    for (x_ = kFromX; x_ < kFarthestX && !touches();) {
      drag(x_ + kDabPx);
      waitUntil(touches, kDabPauseS);
    }
    drag(x_ + kDabPx);
    EXPECT_TRUE(touches()) << log() << errors();
  }
  void pullOut() {
    drag(kFromX);
    desktop->release();
  }
  /// A whole stroke; true when it is in the history as the entry after `undo`.
  bool push(int undo = 0) {
    pushIn();
    pullOut();
    return seesCounts(undo + 1, 0);
  }

  /// A name typed into the dialog that `keys` open.
  void choose(const std::string& keys, const std::string& name) {
    const Screenshot before = desktop->screenshot();
    desktop->key(keys);
    // It covers the middle, and dims the rest.
    ASSERT_TRUE(waitUntil([&] { return differingFraction(before, desktop->screenshot(), 0.4) > 0.5; }));
    desktop->type(name);
    desktop->key("Return");
  }

  /// The folder that a recording went to, as the window said it.
  std::filesystem::path recorded() const {
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      if (entry.path().filename().string().starts_with("recording-")) return entry.path();
    return {};
  }

  TemporaryFolder folder;
  std::optional<Desktop> desktop;
  std::optional<Process> program;
  std::string log_file = folder / "log.jsonl";

 private:
  // Right of the tools, under the middle. At 800 pixels' height 240 are 14 cm, and the hand starts 21 cm from
  // the tube's axis.
  static constexpr int kFromX = 500, kFarthestX = 1000, kY = 560, kDabPx = 48;
  static constexpr double kDabPauseS = 1.5;  // longer than from one line of the log to the next

  void drag(int to_x) {
    constexpr int kStepPx = 12;
    while (x_ != to_x) {
      x_ += std::clamp(to_x - x_, -kStepPx, kStepPx);
      desktop->moveTo(x_, kY);
      std::this_thread::sleep_for(std::chrono::milliseconds(15));  // as a hand drags
    }
  }

  int x_ = 0;  // the pointer's, in the window
};

/// How far the control points of the one clay are from the other's, at most.
inline double farthestMove(const ClayState& a, const ClayState& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.cage.points.size(); ++i)
    most = std::max(most, (a.cage.points[i] - b.cage.points.at(i)).norm());
  return most;
}

}  // namespace airclay
