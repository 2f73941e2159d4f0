// SPDX-License-Identifier: MIT
// The studio in use: the built program in a window on its own display, with simulated mouse and keyboard. Its
// log, documents and files show the effects. The validation layer runs throughout and reports to standard
// error.
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
  using Strings = std::vector<std::string>;

  void SetUp() override {
    if (!Desktop::possible()) GTEST_SKIP() << "Xvfb is missing; third_party/packages.txt lists the packages";
    desktop.emplace();
  }

  std::string at(const std::string& name) const { return folder / name; }

  /// Opens the window; `arguments` follow `airclay sculpt`.
  void start(const Strings& arguments) {
    std::filesystem::remove(log_file);
    Strings all = {AIRCLAY_PROGRAM, "sculpt", "--log", log_file, "--log-interval", "0.1"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    std::map<std::string, std::string> environment = desktop->environment();
    environment["XDG_CONFIG_HOME"] = at("config");
    environment["XDG_STATE_HOME"] = at("state");
    environment["AIRCLAY_VALIDATION"] = "1";
    program.emplace(all, environment, folder / "output", folder / "errors");
    desktop->findWindow("^Airclay");
    ASSERT_TRUE(sees([](const json&) { return true; })) << errors();
  }
  void startWithoutHint(const Strings& arguments) {
    folder.write("config/airclay/studio.toml", "first_run = false\n");
    start(arguments);
  }

  /// Through the window manager, like the window's close button.
  void close() {
    desktop->key("alt+F4");
    EXPECT_EQ(program->waitForExit(), 0);
    EXPECT_EQ(errors(), "");
  }

  std::string errors() const { return readWhole(folder / "errors", kMaxDocumentBytes); }

  /// The last complete line; null if there is none yet.
  json log() const {
    if (!std::filesystem::exists(log_file)) return nullptr;
    constexpr std::streamoff kMaxLinesBytes = 8192;  // at least two lines
    std::ifstream in(log_file, std::ios::binary | std::ios::ate);
    in.seekg(std::max<std::streamoff>(in.tellg() - std::streampos(kMaxLinesBytes), 0));
    std::string text{std::istreambuf_iterator<char>(in), {}};
    text.erase(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n'));
    return text.empty() ? json(nullptr) : json::parse(text.substr(text.rfind('\n') + 1));
  }
  /// Whether the log reaches this state.
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
  bool seesNote(const std::string& arguments) {
    return sees([&](const json& line) {
      return line["note"].get<std::string>().find(arguments) != std::string::npos;
    });
  }

  /// The document as a crash would leave it: between two edits the file is consistent. The program locks the
  /// file, so this opens a copy.
  Document savedDocument(const std::filesystem::path& file) const {
    const std::filesystem::path copy = folder / "copy.clay";
    std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
    return Document::open(copy);
  }

  /// A screenshot once nothing moves in its middle.
  Screenshot restingFrame() const {
    Screenshot shot = desktop->screenshot();
    const auto rests = [&] {
      std::this_thread::sleep_for(
          std::chrono::milliseconds(1000));  // half a second after a change, the surface becomes finer
      const Screenshot before = std::exchange(shot, desktop->screenshot());
      return differingFraction(before, shot, kMiddle) == 0;
    };
    EXPECT_TRUE(waitUntil(rests));
    return shot;
  }
  static constexpr double kMiddle = 0.7;  // of the display, without panels and the document's name

  /// The mouse hand moves from the side into the clay, along the workspace's y, and stays there in the middle
  /// of a stroke.
  void pushIn() {
    desktop->key("6");
    desktop->moveTo(kFromX, kY);
    desktop->press();
    // How far the hand gets in the press's first frame depends on the machine's speed.
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
  /// A complete stroke; true if it becomes the entry after `undo` entries.
  bool push(int undo = 0) {
    pushIn();
    pullOut();
    return seesCounts(undo + 1, 0);
  }

  /// Types a name into the dialog that `keys` open.
  void choose(const std::string& keys, const std::string& name) {
    const Screenshot before = desktop->screenshot();
    desktop->key(keys);
    // The dialog covers the middle and dims the rest.
    ASSERT_TRUE(waitUntil([&] { return differingFraction(before, desktop->screenshot(), 0.4) > 0.5; }));
    desktop->type(name);
    desktop->key("Return");
  }

  /// The folder of a recording, as reported in the window.
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
  // Right of the tools, below the middle. At a height of 800 pixels, 240 are 14 cm, and the hand starts 21 cm
  // from the tube's axis.
  static constexpr int kFromX = 500, kFarthestX = 1000, kY = 560, kDabPx = 48;
  static constexpr double kDabPauseS = 0.4;  // several times the interval between log lines

  void drag(int to_x) {
    constexpr int kStepPx = 12;
    while (x_ != to_x) {
      x_ += std::clamp(to_x - x_, -kStepPx, kStepPx);
      desktop->moveTo(x_, kY);
      std::this_thread::sleep_for(std::chrono::milliseconds(15));  // as fast as a person drags
    }
  }

  int x_ = 0;  // the pointer's position in the window
};

/// The largest distance between corresponding control points.
inline double farthestMove(const ClayState& a, const ClayState& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.cage.points.size(); ++i)
    most = std::max(most, (a.cage.points[i] - b.cage.points.at(i)).norm());
  return most;
}

}  // namespace airclay
